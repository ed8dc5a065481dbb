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
/// An option of a list in words, with its unit.
const optionUnits = {rate: 'Hz', 'noise-corner': 'Hz', 'max-mode': 'Hz', 'snr-db': 'dB', reverberation: 'dB', 'gain-control': 'dB', 'reverberation-time': 's', 'lead-in': 's', pause: 's', 'max-time': 's',
                     height: 'm', spread: 'm', 'plate-size': 'm', gravity: 'm/s²', velocity: 'm/s', 'min-speed': 'm/s', spin: 'rad/s', tilt: 'rad'};
const optionWords = option => (option === 'snr-db' ? 'signal-to-noise ratio' : option.replace(/-/g, ' ')) + (optionUnits[option] ? ` (${optionUnits[option]})` : '');
const speedAxis = extra => logAxis('normal impact speed v (m/s)', extra);

/// Bars are one standard error, but for those of which a trace says otherwise; its name says which they are.
function withBarsNamed(trace) {
  const {bars = '± standard error', ...rest} = trace;
  return bars && trace.name && trace.error_y && trace.error_y.visible !== false ? {...rest, name: `${trace.name}, ${bars}`} : rest;
}

// Drawn once the whole page stands: a plot takes the size that its place has by then.
const plots = [];
function draw(parent, kind, traces, plotLayout) {
  const node = element('div', {class: 'plot ' + kind});
  parent.append(node);
  plots.push({node, kind, data: traces.map(withBarsNamed), layout: layout(plotLayout)});
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
  const of = node.closest('.figure'), axes = [shown.yaxis, shown.xaxis].map(a => plainText(a && a.title && a.title.text)).filter(Boolean).join(' against ');
  const name = [of ? plainText(of.querySelector('h2').textContent) : '', plainText(shown.title && shown.title.text), axes].filter(Boolean).join('; ');
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
                          element('div', {class: 'save'}, save('SVG', 'Save as SVG', async () => saved(name, 'svg', 'image/svg+xml', (await svgOf(document.getElementById(name))).svg)),
                                  save('PDF', 'Print this figure alone: choose "Save as PDF"', () => printOnly(name)),
                                  save('CSV', 'Save what is drawn as CSV', () => saved(name, 'csv', 'text/csv', csvOf(document.getElementById(name))))));
  parent.append(section);
  return places;
}

const plotsOf = section => plots.filter(plot => section.contains(plot.node));

/// What is drawn where, once each: on the page the caption says it for plots that have no legend of their own.
function legendOf(section, width) {
  const named = new Map(plotsOf(section).filter(plot => plot.layout.showlegend === false).flatMap(plot => plot.data).filter(trace => trace.name && trace.type !== 'heatmap').map(trace => [trace.name, trace]));
  const one = value => Array.isArray(value) ? value[0] : value;
  const data = JSON.parse(JSON.stringify([...named].map(([name, {type, mode, line, marker, fill, fillcolor}]) => (
      {name, type, mode, line, fill, fillcolor, marker: marker && {...marker, color: one(marker.color), size: Math.max(6, one(marker.size) || 0)}, x: [null], y: [null]}))));  // without what is undefined
  const rows = Math.ceil(data.reduce((sum, {name}) => sum + 60 + 7.2 * name.length, 0) / width), hidden = {visible: false};
  return {data, height: data.length ? 10 + 24 * rows : 0, layout: layout({showlegend: true, xaxis: hidden, yaxis: hidden, margin: {l: 10, r: 10, t: 0, b: 0}, legend: {orientation: 'h', x: 0, y: 1, yanchor: 'top', font: {size: 12}}})};
}

/// A figure as one SVG, its plots where they lie on the page, below a legend, in the colours of a light one.
async function svgOf(section) {
  const places = section.querySelector('.plots').getBoundingClientRect();
  let width = 0, height = 0, inner = '';
  const add = async (name, data, shown, size, left, top) => {
    // names that Plotly draws at random are numbers: the same file each time
    const traces = data.map((trace, number) => ({...trace, uid: String(number)}));
    const drawn = await Plotly.toImage(structuredClone({data: traces, layout: {...shown, paper_bgcolor: 'white'}}), {format: 'svg', imageDataOnly: true, ...size});
    const [, chance] = /id="defs-(\w+)"/.exec(drawn);
    // an empty style of its first element stands here or there
    inner += drawn.replaceAll(chance, name).replace(' style=""', '').replace('<svg ', `<svg x="${left}" y="${top}" `);
    width = Math.max(width, Math.ceil(left + size.width));
    height = Math.max(height, Math.ceil(top + size.height));
  };
  const legend = legendOf(section, places.width);
  if (legend.height) await add('legend', legend.data, legend.layout, {width: places.width, height: legend.height}, 0, 0);
  for (const [k, plot] of plotsOf(section).entries()) {
    const at = plot.node.getBoundingClientRect();
    await add('plot' + k, plot.data, plot.layout, {width: plot.node.clientWidth, height: plot.node.clientHeight}, at.left - places.left, legend.height + at.top - places.top);
  }
  return {name: section.id, width, height, csv: csvOf(section), svg: `<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}">${inner}</svg>`};
}
const plainText = text => String(text || '').replaceAll('<br>', ' ').replace(/<[^>]*>/g, '');

/// The points of a trace as [x, y, low, high]; of a band its ends, of a picture in colours what its cells hold.
function pointsOf(trace) {
  const {x, y, z, text, fill, error_y: e} = trace, side = (array, k) => e.type === 'constant' ? e.value : array && array[k];
  if (z) return y.flatMap((v, row) => x.map((u, k) => [u, v, '', '', (text || z)[row][k]]));
  const n = x.length / 2;
  if (fill === 'toself' && n % 1 === 0 && x.slice(0, n).every((u, k) => u === x[2 * n - 1 - k])) return x.slice(0, n).map((u, k) => [u, '', ...[y[k], y[2 * n - 1 - k]].sort((a, b) => a - b)]);
  return x.map((u, k) => {
    const up = e && e.visible !== false ? side(e.array, k) : null, down = e && e.arrayminus ? e.arrayminus[k] : up;
    return [u, y[k], known(down) ? y[k] - down : '', known(up) ? y[k] + up : ''];
  });
}
/// What a figure shows as a table: panel, series, a column for each axis, the ends of bars and bands.
function csvOf(section) {
  const rows = [], axes = [];
  const column = words => { if (!axes.includes(words)) axes.push(words); return axes.indexOf(words); };
  for (const {data, layout: shown} of plotsOf(section)) {
    const axisOf = (trace, which) => shown[(trace[which + 'axis'] || which).replace(/^(.)/, '$1axis')] || {}, words = (trace, which) => { const a = axisOf(trace, which); return plainText(a.words || a.title && a.title.text) || which; };
    for (const trace of data.filter(({x}) => x.some(u => u !== null))) {
      const places = [column(words(trace, 'x')), column(words(trace, 'y'))];
      if (trace.z) places.push(column('bounces'));
      for (const [x, y, low, high, z] of pointsOf(trace)) {
        const cells = [];
        [x, y, z].forEach((value, k) => { if (places[k] !== undefined) cells[places[k]] = value; });
        rows.push({of: [plainText(shown.title && shown.title.text), trace.name || ''], cells, ends: [low, high]});
      }
    }
  }
  return csvText([['panel', 'series', ...axes, 'low', 'high'], ...rows.map(({of, cells, ends}) => [...of, ...axes.map((_, k) => cells[k]), ...ends])]);
}
function saved(name, extension, type, content) {
  const link = element('a', {href: URL.createObjectURL(new Blob([content], {type})), download: `bouncelab-${name}.${extension}`});
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
