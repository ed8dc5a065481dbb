// SPDX-License-Identifier: GPL-3.0-or-later
// Draws the report from the JSON in #data. Shows numbers, computes none (axis ranges and log10 of counts for the eye excepted).
'use strict';

const data = JSON.parse(document.getElementById('data').textContent);
const page = document.getElementById('report');
const {summary, fit, wave, samples} = data;
const few = Boolean(samples);  // few enough to be shown one by one: more are not in the data
const ink = '#1b1f24', soft = '#5b6570', blue = '#1f5fa8', red = '#c0392b', orange = '#d9822b', grey = '#9aa4ae';
const depth = [[0, '#dce8f2'], [0.25, '#9fc3df'], [0.5, '#4a90c2'], [0.75, '#1f5fa8'], [1, '#0b2545']];

// ---- text ------------------------------------------------------------------------------------------------------

function element(tag, attributes, ...children) {
  const node = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes || {})) node.setAttribute(key, value);
  for (const child of children.flat()) node.append(child);
  return node;
}
function add(tag, attributes, ...children) {
  const node = element(tag, attributes, ...children);
  page.append(node);
  return node;
}
const known = x => typeof x === 'number' && Number.isFinite(x);

/// A number with as many digits as its standard error warrants: 0.98169 ± 0.00004.
function measured(value, se) {
  if (!known(value)) return '–';
  if (!known(se) || se <= 0) return number(value);
  const decimals = Math.min(12, Math.max(0, 1 - Math.floor(Math.log10(se))));
  return value.toFixed(decimals) + ' ± ' + se.toFixed(decimals);
}
function number(value, digits = 5) {
  if (!known(value)) return '–';
  if (Number.isInteger(value)) return value.toLocaleString('en-US').replace(/,/g, '\u202f');
  const size = Math.abs(value);
  return size >= 1e5 || (size < 1e-4 && size > 0) ? value.toExponential(digits - 2) : String(+value.toPrecision(digits));
}
function interval(range) {
  if (!Array.isArray(range) || !known(range[0]) || !known(range[1])) return '–';
  const decimals = Math.min(12, Math.max(0, 2 - Math.floor(Math.log10(Math.max(range[1] - range[0], 1e-12)))));
  return `${range[0].toFixed(decimals)} … ${range[1].toFixed(decimals)}`;
}
function table(head, rows) {
  const scroll = add('div', {class: 'scroll'});
  scroll.append(element('table', {},
      element('thead', {}, element('tr', {}, head.map(text => element('th', {}, text)))),
      element('tbody', {}, rows.map(row => element('tr', {}, row.map(cell => element('td', {}, cell)))))));
}

// ---- pictures --------------------------------------------------------------------------------------------------

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
// Drawn once the whole page stands: a plot takes the size that its place has by then.
const pending = [];
function draw(parent, kind, traces, plotLayout) {
  const node = element('div', {class: 'plot ' + kind});
  parent.append(node);
  pending.push(() => Plotly.newPlot(node, traces, layout(plotLayout), {
    responsive: true, displaylogo: false, displayModeBar: kind === 'small' ? false : 'hover',
    toImageButtonOptions: {format: 'svg', filename: 'bouncelab'},
    modeBarButtonsToRemove: ['select2d', 'lasso2d', 'autoScale2d'],
  }));
}
function figure(title, caption) {
  add('h2', {}, title);
  add('p', {class: 'caption'}, caption);
  return add('div', {});
}

function band(curve, color, name) {
  const v = curve.map(p => p.v_mps);
  return {x: v.concat([...v].reverse()), y: curve.map(p => p.hi95).concat(curve.map(p => p.lo95).reverse()), fill: 'toself',
          fillcolor: color, line: {width: 0}, hoverinfo: 'skip', name, type: 'scatter', mode: 'lines'};
}

function centres(edges) { return edges.slice(1).map((right, k) => 0.5 * (right + edges[k])); }

/// Figure 1 (top) of the paper: how often which eps was found at which speed, with the law.
function drawLaw(parent) {
  const traces = [];
  if (few) {
    traces.push({x: samples.v_mps, y: samples.eps, mode: 'markers', type: 'scatter', name: 'samples',
                 error_y: {type: 'data', array: samples.sigma_eps, thickness: 1, width: 0, color: grey},
                 marker: {size: 6, color: blue}, hovertemplate: 'v = %{x:.4f} m/s<br>eps = %{y:.5f}<extra></extra>'});
  } else if (fit && fit.density) {
    const z = fit.density.counts.map(row => row.map(n => n > 0 ? Math.log10(n) : null));
    const most = Math.max(1, Math.ceil(Math.max(...fit.density.counts.flat().map(n => n > 0 ? Math.log10(n) : 0))));
    const ticks = [...Array(most + 1).keys()];
    traces.push({type: 'heatmap', x: centres(fit.density.v_edges_mps), y: centres(fit.density.eps_edges), z,
                 text: fit.density.counts, zmin: 0, colorscale: depth,
                 colorbar: {title: {text: 'samples', side: 'right'}, tickvals: ticks, ticktext: ticks.map(t => number(10 ** t)), thickness: 12,
                            len: 0.9},
                 hovertemplate: 'v = %{x:.3f} m/s<br>eps = %{y:.4f}<br>%{text} samples<extra></extra>'});
  }
  const curve = fit && fit.law && fit.law.curve;
  if (curve && curve.length) {
    if (known(curve[0].lo95)) traces.push(band(curve, 'rgba(192,57,43,.22)', '95% band'));
    traces.push({x: curve.map(p => p.v_mps), y: curve.map(p => p.eps), mode: 'lines', type: 'scatter', name: 'fitted law',
                 line: {color: red, width: 2}, hovertemplate: 'v = %{x:.3f}<br>law %{y:.5f}<extra></extra>'});
  }
  if (summary && summary.truth_curve)
    traces.push({x: summary.truth_curve.map(p => p.v_mps), y: summary.truth_curve.map(p => p.eps), mode: 'lines', type: 'scatter',
                 name: 'what went in', line: {color: ink, width: 1.6, dash: 'dash'},
                 hovertemplate: 'v = %{x:.3f}<br>truth %{y:.5f}<extra></extra>'});
  const peaks = ((fit && fit.histograms) || []).filter(h => h.peak_eps && known(h.peak_eps.value));
  if (!few && peaks.length)
    traces.push({x: peaks.map(h => h.v_mps), y: peaks.map(h => h.peak_eps.value), mode: 'markers', type: 'scatter', name: 'peaks of p(ε)',
                 error_y: {type: 'data', array: peaks.map(h => h.peak_eps.se), thickness: 1.4, width: 3, color: orange},
                 marker: {color: orange, size: 7, line: {color: 'white', width: 1}}, hovertemplate: 'v = %{x:.2f}<br>peak %{y:.5f}<extra></extra>'});
  const range = fit && fit.density && !few ? [fit.density.eps_edges[0], fit.density.eps_edges.at(-1)] : undefined;
  draw(parent, '', traces, {xaxis: axis('normal impact speed v (m/s)'), yaxis: axis('coefficient of restitution ε', {range}),
                            showlegend: true});
}

/// Figure 1 (bottom): p(eps) in windows of speed, log axis, with the two exponentials.
function drawHistogram(parent, h) {
  const width = h.bins.eps_edges[1] - h.bins.eps_edges[0];
  const n = h.n;
  const x = centres(h.bins.eps_edges);
  const used = x.map((_, k) => k).filter(k => h.bins.counts[k] > 0);
  const traces = [{
    x: used.map(k => x[k]), y: used.map(k => h.bins.counts[k] / (n * width)), type: 'scatter', mode: 'markers',
    error_y: {type: 'data', array: used.map(k => Math.sqrt(h.bins.counts[k]) / (n * width)), thickness: 1, width: 0, color: grey},
    marker: {size: 4.5, color: blue}, text: used.map(k => h.bins.counts[k]), hovertemplate: 'ε = %{x:.4f}<br>%{text} samples<extra></extra>',
  }];
  if (h.curve && h.curve.eps)
    traces.push({x: h.curve.eps, y: h.curve.density, type: 'scatter', mode: 'lines', line: {color: red, width: 1.8}, hoverinfo: 'skip'});
  const floor = 0.4 / (n * width);
  const top = Math.max(...h.bins.counts.map(c => c / (n * width)), ...((h.curve && h.curve.density) || [0]));
  draw(parent, 'small', traces, {
    showlegend: false, margin: {l: 52, r: 8, t: 30, b: 42},
    title: {text: `v = ${number(h.v_mps, 3)} m/s, n = ${number(n)}`, font: {size: 13}, x: 0.5, y: 0.97},
    xaxis: axis('ε', {nticks: 5}), yaxis: axis('p(ε)', {type: 'log', range: [Math.log10(floor), Math.log10(top) + 0.25], dtick: 1, exponentformat: 'power'}),
  });
}

/// The whole recording as an envelope, with what was found.
function drawWave(parent) {
  const e = wave.envelope;
  const traces = [
    {x: e.t_s, y: e.lo, mode: 'lines', type: 'scatter', line: {width: 0.6, color: grey}, hoverinfo: 'skip', showlegend: false},
    {x: e.t_s, y: e.hi, mode: 'lines', type: 'scatter', line: {width: 0.6, color: grey}, fill: 'tonexty', fillcolor: 'rgba(120,132,145,.45)',
     name: 'sound', hoverinfo: 'skip'},
  ];
  const level = 1.08 * Math.max(...e.hi.map(Math.abs), ...e.lo.map(Math.abs), 1e-12);
  const plain = wave.marks.filter(m => !m.flags), said = wave.marks.filter(m => m.flags);
  const marks = (list, color, name) => ({
    x: list.map(m => m.t_s), y: list.map(() => level), mode: 'markers', type: 'scatter', name,
    marker: {symbol: 'line-ns', size: 9, line: {width: 1.2, color}}, text: list.map(m => `drop ${m.drop}, impact ${m.impact}${m.flags ? ', ' + m.flags : ''}`),
    hovertemplate: '%{x:.6f} s<br>%{text}<extra></extra>'});
  traces.push(marks(plain, red, 'impacts found'));
  if (said.length) traces.push(marks(said, orange, 'with a flag'));
  draw(parent, 'low', traces, {xaxis: axis('time (s)'), yaxis: axis('amplitude', {range: [-level * 1.02, level * 1.12]})});
}

/// The sound around one impact; time counts from where it was found.
function drawExcerpt(parent, excerpt) {
  const origin = excerpt.marks.length ? excerpt.marks[0].t_s : excerpt.t0_s;
  const ms = excerpt.samples.map((_, k) => 1e3 * (excerpt.t0_s + k * excerpt.dt_s - origin));
  const top = 1.05 * Math.max(...excerpt.samples.map(Math.abs), 1e-12);
  const shapes = [];
  for (const mark of excerpt.marks) {
    const t = 1e3 * (mark.t_s - origin), s = known(mark.sigma_t_s) ? 1e3 * mark.sigma_t_s : 0;
    shapes.push({type: 'line', x0: t, x1: t, y0: -top, y1: top, line: {color: red, width: 1.3}});
    if (s > 0) shapes.push({type: 'rect', x0: t - s, x1: t + s, y0: -top, y1: top, fillcolor: red, opacity: 0.18, line: {width: 0}});
  }
  const first = excerpt.marks[0];
  const title = excerpt.title + (first ? `, t = ${first.t_s.toFixed(6)} s` + (known(first.sigma_t_s) ? ` ± ${number(1e6 * first.sigma_t_s, 2)} µs` : '') : '');
  draw(parent, 'small', [{x: ms, y: excerpt.samples, mode: 'lines', type: 'scatter', line: {color: ink, width: 1}, hovertemplate: '%{x:.4f} ms<extra></extra>'}],
       {shapes, showlegend: false, margin: {l: 56, r: 8, t: 30, b: 42}, title: {text: title, font: {size: 13}, x: 0.5, y: 0.97},
        xaxis: axis('time after the impact found (ms)', {nticks: 6}), yaxis: axis('amplitude', {range: [-top, top], nticks: 5})});
}

/// Does the law hold at every speed? Pulls of the location in bins of speed.
function drawResiduals(parent, residuals) {
  const used = residuals.filter(r => known(r.pull));
  draw(parent, 'low', [{x: used.map(r => r.v_mps), y: used.map(r => r.pull), mode: 'markers', type: 'scatter', marker: {size: 7, color: blue},
                        error_y: {type: 'constant', value: 1, thickness: 1, width: 0, color: grey}, text: used.map(r => r.n),
                        hovertemplate: 'v = %{x:.3f} m/s<br>pull %{y:.2f}<br>%{text} samples<extra></extra>'}],
       {showlegend: false, xaxis: axis('normal impact speed v (m/s)'), yaxis: axis('pull of ε(v)', {zeroline: true, zerolinecolor: red, zerolinewidth: 1.4})});
}

// ---- the page --------------------------------------------------------------------------------------------------

function card(value, text) { return element('div', {class: 'card'}, element('b', {}, value), element('span', {}, text)); }

function head() {
  add('h1', {}, data.title);
  add('p', {class: 'sub'}, data.program);
  const warnings = [...new Set([...((summary && summary.warnings) || []), ...((fit && fit.warnings) || [])])];
  if (warnings.length) add('div', {class: 'warnings'}, element('ul', {}, warnings.map(w => element('li', {}, w))));
  const cards = [];
  if (summary && known(summary.n_impacts))
    cards.push(card(`${number(summary.n_found)} of ${number(summary.n_impacts)}`, 'impacts found in the sound'),
               card(`${number(summary.n_missed)} / ${number(summary.n_invented)}`, 'missed / invented'));
  else if (summary && known(summary.n_onsets)) cards.push(card(number(summary.n_onsets), 'impacts found in the sound'));
  if (summary && known(summary.n_drops)) cards.push(card(number(summary.n_drops), summary.n_drops === 1 ? 'drop' : 'drops'));
  if (summary && known(summary.time_rms_within_drops_s)) cards.push(card(`${number(1e6 * summary.time_rms_within_drops_s, 3)} µs`, 'rms error of the times within a drop'));
  if (summary && known(summary.n_samples)) cards.push(card(number(summary.n_samples), 'samples of ε'));
  if (summary && known(summary.eps_median)) cards.push(card(number(summary.eps_median, 4), 'median ε'));
  if (cards.length) add('div', {class: 'cards'}, cards);
}

function nodesTable() {
  const loop = summary && summary.eps_nodes;
  if (loop && loop.length && loop.some(n => n.from_true_times)) {
    add('h2', {}, 'What went in, what came out');
    const pull = (x, se, truth) => known(x) && known(se) && se > 0 && known(truth) ? ((x - truth) / se).toFixed(1) : '–';
    const rows = loop.map(n => [`ε(${number(n.v_mps)} m/s)`, number(n.truth, 6), measured((n.from_true_times || {}).eps, (n.from_true_times || {}).se),
      measured((n.from_sound || {}).eps, (n.from_sound || {}).se), pull((n.from_sound || {}).eps, (n.from_sound || {}).se, n.truth)]);
    for (const c of summary.constants || [])
      rows.push([c.name, number(c.truth), measured((c.from_true_times || {}).value, (c.from_true_times || {}).se),
                 measured((c.from_sound || {}).value, (c.from_sound || {}).se), pull((c.from_sound || {}).value, (c.from_sound || {}).se, c.truth)]);
    table(['', 'truth', 'from true times', 'from sound', 'pull'], rows);
    add('p', {class: 'caption'}, 'Pull: (from sound − truth) / standard error; honest errors give values of about ±1.');
  }
  const law = fit && fit.law;
  if (!law) return;
  add('h2', {}, 'The law of restitution');
  add('p', {class: 'caption'}, `ε(v) = 1 + C₂A₂ v^(1/5) + C₄A₄ v^(2/5) + C₅A₅ v^(1/2). Method: ${law.method || '–'}; ${number(law.n)} samples; status: ${law.status || '–'}.`);
  const rows = ['A2', 'A4', 'A5'].filter(k => law[k] && known(law[k].value)).map(
      k => [k, measured(law[k].value, law[k].se), interval(law[k].ci68), interval(law[k].ci95)]);
  for (const node of law.nodes || []) rows.push([`ε(${number(node.v_mps, 3)} m/s)`, measured(node.eps, node.se), interval(node.ci68), interval(node.ci95)]);
  if (rows.length) table(['', 'value', '68% interval', '95% interval'], rows);
  const quality = [];
  if (law.correlation) quality.push(`correlations A₂A₄ ${number(law.correlation[0][1], 4)}, A₂A₅ ${number(law.correlation[0][2], 4)}, A₄A₅ ${number(law.correlation[1][2], 4)}`);
  if (known(law.condition_number)) quality.push(`condition number ${number(law.condition_number, 3)}`);
  if (known(law.loglik)) quality.push(`log-likelihood ${number(law.loglik, 7)}`);
  if (known(law.chi2) && known(law.ndf)) quality.push(`χ²/ndf = ${number(law.chi2, 5)}/${number(law.ndf)}`);
  if (known(law.p_value)) quality.push(`p = ${number(law.p_value, 3)}`);
  if (quality.length) add('p', {class: 'caption'}, quality.join('; ') + '.');
  const others = [['least squares', fit.law_least_squares], ['viscoelastic, one γ', fit.law_viscoelastic]].filter(o => o[1] && o[1].nodes && o[1].nodes.length);
  if (others.length) {
    const constants = l => ['A2', 'A4', 'A5', 'gamma'].filter(k => l[k] && known(l[k].value)).map(k => `${k === 'gamma' ? 'γ' : k} = ${measured(l[k].value, l[k].se)}`).join(', ');
    table(['other fits', ...others[0][1].nodes.map(n => `ε(${number(n.v_mps, 3)} m/s)`)],
          others.map(([name, l]) => [name, ...l.nodes.map(n => measured(n.eps, n.se))]));
    add('p', {class: 'caption'}, others.map(([name, l]) => `${name}: ${constants(l)}`).join('; ') + '.');
  }
}

function slopesTable() {
  const rows = [];
  if (summary && summary.slopes && summary.slopes.length) {
    const cell = x => x ? measured(x.value, x.se) : '–';
    for (const s of summary.slopes)
      rows.push([`${number(s.v_mps)} m/s`, cell((s.from_true_times || {}).rising), cell((s.from_sound || {}).rising), cell((s.from_true_times || {}).falling),
                 cell((s.from_sound || {}).falling)]);
    table(['window', 'rising, true times', 'rising, sound', 'falling, true times', 'falling, sound'], rows);
    return;
  }
  for (const h of (fit && fit.histograms) || [])
    if (h.slope_rising) rows.push([`${number(h.v_mps)} m/s`, number(h.n), measured((h.peak_eps || {}).value, (h.peak_eps || {}).se),
                                   measured(h.slope_rising.value, h.slope_rising.se), measured(h.slope_falling.value, h.slope_falling.se),
                                   number(h.p_value, 3), number(h.delta_aic_gaussian, 4)]);
  if (rows.length) table(['window', 'n', 'peak ε', 'rising slope', 'falling slope', 'p', 'ΔAIC normal'], rows);
}

function work() {
  if (!summary || !summary.seconds) return;
  add('h2', {}, 'Where the time went');
  table(['stage', 'seconds'], Object.entries(summary.seconds).map(([stage, s]) => [stage.replace(/_/g, ' '), s.toFixed(2)]));
}

head();
if (data.sweep) sweepSection(data.sweep);
if (data.paper && data.simulation) paperSection(data.paper, data.simulation);
if (fit) drawLaw(figure('Coefficient of restitution against impact speed',
               (few ? 'Points: samples, with the error that timing alone gives them.' : 'Colour: number of samples in each cell, on a logarithmic scale.') + ' Line and band: the fitted law with its 95% interval. Zoom with the mouse; the camera saves an SVG.'));
nodesTable();
if (fit && fit.law && (fit.law.residuals || []).some(r => known(r.pull)))
  drawResiduals(figure('Does the law hold at every speed?', 'Mean residual in bins of speed over its standard error; points scatter about 0 by about 1 where it does.'), fit.law.residuals);
const histograms = (fit && fit.histograms) || [];
const shown = histograms.filter(h => h.bins && h.curve && (h.curve.eps || []).length);
if (shown.length) {
  const parent = figure('Distribution of ε at fixed speed',
                        'Points: normalised frequency with Poisson errors, logarithmic axis. Lines: two exponentials, one rising, one falling, of different slope, as the timing noise blurs them.');
  parent.className = 'grid';
  for (const h of shown) drawHistogram(parent, h);
} else if (histograms.length) {
  add('h2', {}, 'Distribution of ε at fixed speed');
  add('p', {class: 'caption'}, 'Too few samples at any one speed: ' + histograms.map(h => `${number(h.n)} at ${number(h.v_mps, 2)} m/s`).join(', ') + '.');
}
slopesTable();
if (wave && wave.envelope) {
  const parent = figure('The sound and the impacts found in it', `${wave.recording || ''}, ${number(wave.rate_hz)} Hz, channel ${wave.channel}. ` +
                        'Grey: extremes of the recording; marks on top: impacts. Below: excerpts with the time found (line) and its standard error (band).');
  drawWave(parent);
  const grid = element('div', {class: 'grid'});
  parent.append(grid);
  for (const excerpt of wave.excerpts || []) drawExcerpt(grid, excerpt);
}
work();
add('footer', {}, `${data.program}. Model: Montaine, Heckel, Kruelle, Schwager, Pöschel, Phys. Rev. E 84, 041306 (2011).`);
for (const plot of pending) plot();
