// SPDX-License-Identifier: GPL-3.0-or-later
// How figures look, when they are drawn, how they are saved.


const ink = '#1b1f24', blue = '#1f5fa8', red = '#c0392b', orange = '#d9822b', green = '#2e7d5b', grey = '#9aa4ae';
const depth = [[0, '#dce8f2'], [0.25, '#9fc3df'], [0.5, '#4a90c2'], [0.75, '#1f5fa8'], [1, '#0b2545']];
const narrow = window.innerWidth < 600;

function layout(extra) {
  const base = {
    font: {family: 'system-ui, "DejaVu Sans", sans-serif', size: narrow ? 11 : 13, color: ink},
    margin: {l: narrow ? 52 : 68, r: narrow ? 8 : 18, t: 26, b: narrow ? 70 : 50}, paper_bgcolor: 'white', plot_bgcolor: 'white',
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
const pending = [];
function draw(parent, kind, traces, plotLayout) {
  const node = element('div', {class: 'plot ' + kind});
  parent.append(node);
  pending.push(() => Plotly.newPlot(node, traces, layout(plotLayout), {
    responsive: true, displaylogo: false, displayModeBar: kind.includes('small') ? false : 'hover',
    toImageButtonOptions: {format: 'svg', filename: 'bouncelab'}, modeBarButtonsToRemove: ['select2d', 'lasso2d', 'autoScale2d'],
  }));
  return node;
}

/// A figure with its title, its caption and what saves it. `name` is its file name and its address: #only=name shows
/// this figure and nothing else, on a page of its size.
function figure(name, title, caption) {
  const plots = element('div', {class: 'plots'});
  const save = (label, hint, action) => {
    const button = element('button', {type: 'button', title: hint}, label);
    button.addEventListener('click', action);
    return button;
  };
  const section = element('section', {class: 'figure', id: name}, element('h2', {}, title), element('p', {class: 'caption'}, caption), plots,
                          element('div', {class: 'save'}, save('SVG', 'Save as SVG', () => saveSvg(name)),
                                  save('PDF', 'Print this figure alone: choose "Save as PDF"', () => printOnly(name))));
  page.append(section);
  return plots;
}

function saveSvg(name) {
  [...document.querySelectorAll(`#${name} .plot`)].forEach((node, k, all) => Plotly.downloadImage(node, {
    format: 'svg', filename: `bouncelab-${name}${all.length > 1 ? '-' + (k + 1) : ''}`, width: node.clientWidth, height: node.clientHeight}));
}

function showOnly(name) {
  const section = document.getElementById(name);
  if (!section) return;
  const plots = section.querySelector('.plots');
  const {width, height} = plots.getBoundingClientRect();
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
  for (const plot of pending) plot();
  const asked = /^#only=([\w-]+)$/.exec(location.hash);
  if (asked) showOnly(asked[1]);
}
