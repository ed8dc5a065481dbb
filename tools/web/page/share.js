// SPDX-License-Identifier: GPL-3.0-or-later
// The answer as a text and a picture, for the phone's own sharing or, where a browser has none, the clipboard and a file.
// Nothing is uploaded.
import {say} from './trouble.js';

const kDrawn = ['fill', 'fill-opacity', 'stroke', 'stroke-width', 'stroke-opacity', 'stroke-dasharray', 'opacity', 'font-family', 'font-size', 'font-weight', 'text-anchor'];
const kScale = 2;              // pixels of the picture for one of the page
const kMargin = 16, kLine = 22;  // pixels of the page

/// The lines in which a text fits into a width.
function wrapped(context, text, width) {
  const lines = [''];
  for (const word of text.split(' ')) {
    const longer = `${lines.at(-1)} ${word}`.trim();
    if (context.measureText(longer).width <= width || !lines.at(-1)) lines[lines.length - 1] = longer;
    else lines.push(word);
  }
  return lines;
}

/// An SVG of the page with sentences above it, as PNG: the page's style sheet does not reach into a picture, so each element gets what it has of it.
async function pictureOf(svg, sentences) {
  const clone = svg.cloneNode(true);
  const copies = [clone, ...clone.querySelectorAll('*')];
  for (const [k, node] of [svg, ...svg.querySelectorAll('*')].entries())
    for (const name of kDrawn) copies[k].setAttribute(name, getComputedStyle(node).getPropertyValue(name));
  const {width, height} = svg.getBoundingClientRect(), body = getComputedStyle(document.body);
  clone.setAttribute('width', width);
  clone.setAttribute('height', height);
  const image = new Image();
  image.src = 'data:image/svg+xml,' + encodeURIComponent(new XMLSerializer().serializeToString(clone));
  await image.decode();
  const canvas = document.createElement('canvas'), context = canvas.getContext('2d'), font = `16px ${body.fontFamily}`;
  context.font = font;
  const lines = sentences.flatMap(sentence => wrapped(context, sentence, width));
  canvas.width = kScale * (width + 2 * kMargin);
  canvas.height = kScale * (height + lines.length * kLine + 3 * kMargin);
  context.scale(kScale, kScale);
  context.fillStyle = body.backgroundColor;
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.fillStyle = body.color;
  context.font = font;
  for (const [k, line] of lines.entries()) context.fillText(line, kMargin, kMargin + (k + 0.75) * kLine);
  context.drawImage(image, kMargin, 2 * kMargin + lines.length * kLine, width, height);
  return new Promise(resolve => canvas.toBlob(resolve, 'image/png'));
}

/// @param stem  what the picture's name begins with
/// @param save  a file, by name, parts and type
export async function share(stem, save) {
  const sentences = [...document.querySelectorAll('#answer .lead, #answer p:not(.caption)')].map(node => node.textContent.replace(/\s+/g, ' ').trim()).filter(Boolean);
  const picture = await pictureOf(document.querySelector('#law-plot svg'), sentences);
  const file = new File([picture], `${stem}-eps.png`, {type: 'image/png'}), text = sentences.join('\n');
  if (navigator.canShare?.({files: [file], text})) {
    await navigator.share({files: [file], text}).catch(error => { if (error.name !== 'AbortError') throw error; });
    return;
  }
  save(file.name, [picture], file.type);
  const isCopied = await navigator.clipboard?.writeText(text).then(() => true, () => false);
  say(isCopied ? 'The picture is saved, the answer is on the clipboard.' : 'The picture is saved.');
}
