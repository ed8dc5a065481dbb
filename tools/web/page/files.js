// SPDX-License-Identifier: GPL-3.0-or-later
// From a file to samples. WAV and FLAC go to our own reader in the worker; everything else is decoded by the browser at
// the file's own rate, so that nothing is resampled.
import {containerRate, isOurs} from './container_rate.js';
import {Trouble} from './trouble.js';

/// Samples are 32-bit floats in a 32-bit address space, beside what the analysis needs.
const kMostBytes = 300e6;
const kMostSeconds = 1800;

/// Rates that every browser's decoder has to take (Web Audio 1.1, 1.7); where the header does not say, 48 kHz.
const allowedRate = rate => rate >= 8000 && rate <= 96000;

/// What people choose by mistake, by the first bytes.
const kOthers = [[/^%PDF/, 'a PDF'], [/^(\s*(<\?xml[^>]*>\s*)?<svg|\xff\xd8\xff|\x89PNG|GIF8|RIFF....WEBP|....ftyp(heic|heix|mif1|avif))/s, 'a picture'], [/^PK\x03\x04/, 'an archive or a document (ZIP, Excel, Word)'], [/^(\xd0\xcf\x11\xe0|\{\\rtf)/, 'a document'], [/^\s*<(!doctype )?html/i, 'a web page']];

/// Throws what to do where the file is neither sound nor a table.
function refuseOthers(bytes, name) {
  const head = String.fromCharCode(...bytes.subarray(0, 64)), other = kOthers.find(([begin]) => begin.test(head));
  if (other) throw new Trouble(`${name} is ${other[1]}: please choose the recording itself (sound or video), or save the table with the times or heights as CSV and choose that. Few numbers can be typed.`);
}

/// @param isTable  it is not sound
/// @returns {bytes} for our own reader, with `refused`, what to say if that cannot read them either, or {channels: [Float32Array], rate_hz, format, lossy: the coding, note}
export async function readFile(file, isTable) {
  if (file.size > kMostBytes)
    throw new Trouble(`${file.name} has ${Math.round(file.size / 1e6)} MB; this page takes up to ${kMostBytes / 1e6} MB: please cut out the part with the bounces.`);
  if (file.size === 0) throw new Trouble(`${file.name} is empty.`);
  let bytes;
  try {
    bytes = new Uint8Array(await file.arrayBuffer());
  } catch {
    throw new Trouble(`${file.name} cannot be read; is it a folder, or was it moved?`);
  }
  if (isTable) return {bytes, isTable};
  refuseOthers(bytes, file.name);
  return isOurs(bytes) ? {bytes} : decoded(bytes, file.name);
}

async function decoded(bytes, name) {
  const header = containerRate(bytes);
  if (header.hasSound === false) throw new Trouble(`${name} is a video without sound.`);
  const own = header.rate_hz !== null && allowedRate(header.rate_hz), rate = own ? header.rate_hz : 48000;
  let buffer;
  try {
    buffer = await new OfflineAudioContext(1, 1, rate).decodeAudioData(bytes.slice().buffer);  // which takes it away
  } catch {
    return {bytes, refused: `${name} has no sound that can be read here; WAV, FLAC, MP3 and M4A are read nearly everywhere.`};
  }
  if (buffer.duration > kMostSeconds)
    throw new Trouble(`${name} lasts ${Math.round(buffer.duration / 60)} minutes; this page takes up to ${kMostSeconds / 60}: please cut out the part with the bounces.`);
  const channels = [...Array(buffer.numberOfChannels).keys()].map(k => {
    const samples = new Float32Array(buffer.length);
    buffer.copyFromChannel(samples, k);
    return samples;
  });
  const note = own ? '' : header.rate_hz ? `Its rate of ${header.rate_hz} Hz was converted to ${rate} Hz by the browser.` :
      `Its header does not state a sampling rate; the browser decoded it at ${rate} Hz.`;
  return {channels, rate_hz: buffer.sampleRate, format: header.container || 'decoded by the browser', lossy: header.lossy, note};
}

/// Files dropped anywhere on the page, or chosen.
export function acceptFiles(button, input, take) {
  button.addEventListener('click', () => input.click());
  input.addEventListener('change', () => { take([...input.files]); input.value = ''; });
  let depth = 0;  // enter and leave come for every element below the pointer
  const hasFiles = event => [...(event.dataTransfer?.types ?? [])].includes('Files');
  window.addEventListener('dragenter', event => { if (hasFiles(event)) document.body.classList.toggle('dropping', ++depth > 0); });
  window.addEventListener('dragleave', event => { if (hasFiles(event)) document.body.classList.toggle('dropping', --depth > 0); });
  window.addEventListener('dragover', event => { if (hasFiles(event)) event.preventDefault(); });
  window.addEventListener('drop', event => {
    if (!hasFiles(event)) return;
    event.preventDefault();
    depth = 0;
    document.body.classList.remove('dropping');
    take([...event.dataTransfer.files]);
  });
}
