// SPDX-License-Identifier: GPL-3.0-or-later
// How figures look, when they are drawn, how they are saved.


const ink = '#1b1f24', blue = '#1f5fa8', red = '#c0392b', orange = '#d9822b', green = '#2e7d5b', grey = '#9aa4ae';
const depth = [[0, '#dce8f2'], [0.25, '#9fc3df'], [0.5, '#4a90c2'], [0.75, '#1f5fa8'], [1, '#0b2545']];
const narrow = window.innerWidth < 600, noHover = window.matchMedia('(hover: none)').matches;

/// Pictures are described in the colours of a light page; on a dark one each is drawn as its counterpart here.
const darkColours = new Map(Object.entries({
  [ink]: '#e4e8ec', [blue]: '#6db0f2', [red]: '#ff7b6b', [orange]: '#f0a560', [green]: '#5cc796', [grey]: '#7f8b97', '#8b949e': '#67727d', '#eef1f4': '#272e36', white: '#14181d',
  '#dce8f2': '#18344f', '#9fc3df': '#24609a', '#4a90c2': '#468fc9', '#0b2545': '#e3f0fc',  // many samples: bright
}));
const darkFills = [['rgba(31,95,168,', 'rgba(109,176,242,'], ['rgba(192,57,43,', 'rgba(255,123,107,']];
const darkColour = text => darkColours.get(text) || darkFills.reduce((t, [light, dark]) => t.replace(light, dark), text);
const darkened = x => typeof x === 'string' ? darkColour(x) : Array.isArray(x) ? x.map(darkened) :
    x && typeof x === 'object' ? Object.fromEntries(Object.entries(x).map(([key, value]) => [key, darkened(value)])) : x;
const darkPage = window.matchMedia('(prefers-color-scheme: dark)');

function layout(extra) {
  const base = {
    font: {family: 'system-ui, "DejaVu Sans", sans-serif', size: narrow ? 11 : 13, color: ink},
    margin: {l: narrow ? 52 : 68, r: narrow ? 8 : 18, t: 26, b: narrow ? 70 : 50}, paper_bgcolor: 'rgba(0,0,0,0)', plot_bgcolor: 'rgba(0,0,0,0)',
    modebar: {bgcolor: 'rgba(0,0,0,0)', color: grey, activecolor: ink},
    hoverlabel: {font: {size: 12}}, legend: {orientation: 'h', y: 1.02, yanchor: 'bottom', x: 0, font: {size: narrow ? 10 : 12}},
  };
  return Object.assign(base, extra);
}
function axis(title, extra) {
  return Object.assign({title: {text: title, standoff: 6}, showline: true, linecolor: '#8b949e', mirror: true, ticks: 'outside',
                        tickcolor: '#8b949e', gridcolor: '#eef1f4', zeroline: false, automargin: true}, extra);
}
/// Logarithmic axis with plain numbers at 1, 2, 3, 5, 7 of each decade, powers of ten below a thousandth.
const ticks125 = [...Array(18).keys()].flatMap(d => [1, 2, 3, 5, 7].map(m => ({mantissa: m, exponent: d - 10})));
const tickText = t => t.exponent < -3 ? `${t.mantissa}·10<sup>${t.exponent}</sup>` : String(+(t.mantissa * 10 ** t.exponent).toPrecision(1));
const logAxis = (title, extra) => axis(title, Object.assign({type: 'log', tickmode: 'array', tickvals: ticks125.map(t => t.mantissa * 10 ** t.exponent),
                                                             ticktext: ticks125.map(tickText)}, extra));
/// What replaces the numbers where the values span so much that they would crowd.
const decades = {tickmode: 'linear', tick0: 0, dtick: 1, exponentformat: 'power'};
function decadesIfMany(traces) {
  const values = traces.flatMap(t => t.y).filter(y => y > 0);
  return Math.max(...values) > 100 * Math.min(...values) ? decades : {};
}
const speedAxis = extra => logAxis('normal impact speed v (m/s)', extra);

// Drawn once the whole page stands: a plot takes the size that its place has by then.
const plots = [];
function draw(parent, kind, traces, plotLayout) {
  const node = element('div', {class: 'plot ' + kind});
  parent.append(node);
  plots.push({node, kind, data: traces, layout: layout(plotLayout)});
  return node;
}
function drawAll(dark) {
  const coloured = dark ? darkened : x => structuredClone(x);  // Plotly writes into what it is given
  for (const plot of plots) {
    describePlot(plot);
    const width = document.body.classList.contains('printing') ? {width: plot.node.clientWidth} : {};
    Plotly.newPlot(plot.node, coloured(plot.data), {...coloured(plot.layout), ...width}, {
      responsive: true, displaylogo: false, displayModeBar: narrow || noHover || plot.kind.includes('small') ? false : 'hover',  // on a phone it would lie on the legend
      toImageButtonOptions: {format: 'svg', filename: 'bouncelab'}, modeBarButtonsToRemove: ['select2d', 'lasso2d', 'autoScale2d'],
    });
  }
}
/// What a screen reader says of a plot: its title or its figure's, and what is drawn over what.
function describePlot({node, layout: shown}) {
  const plain = text => String(text || '').replace(/<[^>]*>/g, '');
  const of = node.closest('.figure'), axes = [shown.yaxis, shown.xaxis].map(a => plain(a && a.title && a.title.text)).filter(Boolean).join(' against ');
  const name = [of ? plain(of.querySelector('h2').textContent) : '', plain(shown.title && shown.title.text), axes].filter(Boolean).join('; ');
  node.setAttribute('role', 'img');
  node.setAttribute('aria-label', `Plot: ${name}. Its numbers are in the tables below and in the files beside this report.`);
}

/// A figure with its title, its caption and what saves it. `name` is its file name and its address: #only=name shows
/// this figure and nothing else, on a page of its size.
function figure(name, title, caption, parent = page) {
  const places = element('div', {class: 'plots'});
  const save = (label, hint, action) => {
    const button = element('button', {type: 'button', title: hint, 'aria-label': `${hint}: ${title}`}, label);
    button.addEventListener('click', action);
    return button;
  };
  const section = element('section', {class: 'figure', id: name, 'aria-label': title}, element('h2', {}, title), element('p', {class: 'caption'}, caption), places,
                          element('div', {class: 'save'}, save('SVG', 'Save as SVG', () => saveSvg(name)),
                                  save('PDF', 'Print this figure alone: choose "Save as PDF"', () => printOnly(name))));
  parent.append(section);
  return places;
}

/// A figure as one SVG, its plots where they lie on the page, in the colours of a light one.
async function svgOf(section) {
  const places = section.querySelector('.plots').getBoundingClientRect();
  let width = 0, height = 0, inner = '';
  for (const [k, plot] of plots.filter(plot => section.contains(plot.node)).entries()) {
    const at = plot.node.getBoundingClientRect(), size = {width: plot.node.clientWidth, height: plot.node.clientHeight};
    // names that Plotly draws at random are numbers: the same file each time
    const traces = plot.data.map((trace, number) => ({...trace, uid: String(number)}));
    const drawn = await Plotly.toImage(structuredClone({data: traces, layout: {...plot.layout, paper_bgcolor: 'white'}}), {format: 'svg', imageDataOnly: true, ...size});
    const [, chance] = /id="defs-(\w+)"/.exec(drawn);
    // an empty style of its first element stands here or there
    inner += drawn.replaceAll(chance, 'plot' + k).replace(' style=""', '').replace('<svg ', `<svg x="${at.left - places.left}" y="${at.top - places.top}" `);
    width = Math.max(width, Math.ceil(at.right - places.left));
    height = Math.max(height, Math.ceil(at.bottom - places.top));
  }
  return {name: section.id, width, height, svg: `<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}">${inner}</svg>`};
}
async function saveSvg(name) {
  const {svg} = await svgOf(document.getElementById(name));
  const link = element('a', {href: URL.createObjectURL(new Blob([svg], {type: 'image/svg+xml'})), download: `bouncelab-${name}.svg`});
  link.click();
  URL.revokeObjectURL(link.href);
}
/// #figures: the page becomes a list of its figures, for `bouncelab report --figures`.
async function listFigures() {
  const all = [];
  for (const section of document.querySelectorAll('.figure')) all.push(await svgOf(section));
  document.body.replaceChildren(element('script', {type: 'application/json', id: 'figures'}, JSON.stringify(all).replaceAll('<', '\\u003c')));
}

function showOnly(name) {
  const section = document.getElementById(name);
  if (!section) return;
  const {width, height} = section.querySelector('.plots').getBoundingClientRect();
  document.body.classList.add('only');
  section.classList.add('shown');
  document.head.append(element('style', {id: 'page-size'}, `@page { size: ${Math.ceil(width)}px ${Math.ceil(height) + 2}px; margin: 0 } .figure.shown .plots { width: ${Math.ceil(width)}px }`));
}
function showAll() {
  document.body.classList.remove('only');
  for (const section of document.querySelectorAll('.figure.shown')) section.classList.remove('shown');
  document.getElementById('page-size')?.remove();
}
function printOnly(name) {
  showOnly(name);
  window.addEventListener('afterprint', showAll, {once: true});
  window.print();
}
/// After everything is drawn.
function finishPlots() {
  drawAll(darkPage.matches);
  darkPage.addEventListener('change', () => drawAll(darkPage.matches));
  window.addEventListener('beforeprint', () => {
    if (!document.body.classList.contains('only')) document.body.classList.add('printing');
    drawAll(false);
  });
  window.addEventListener('afterprint', () => {
    document.body.classList.remove('printing');
    drawAll(darkPage.matches);
  });
  const asked = /^#only=([\w-]+)$/.exec(location.hash);
  if (asked) showOnly(asked[1]);
  if (location.hash === '#figures') listFigures();
}
