// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of the scatter of eps: histograms, slopes, energy picture, error budget.


/// The closed form in a window of speeds, where the summary has it.
const expectedDensity = h => ((summary && summary.theory && summary.theory.densities) || []).find(d => Math.abs(d.v_mps - h.v_mps) < 1e-9);

/// Figure 1 (bottom) of the paper: p(eps) in windows of speed, log axis, with the two exponentials and a normal; after a
/// loop also the simulated impacts, without sound, and the closed form.
function drawHistogram(parent, h) {
  const width = h.bins.eps_edges[1] - h.bins.eps_edges[0], unit = h.n * width;
  const x = centres(h.bins.eps_edges);
  const used = x.map((_, k) => k).filter(k => h.bins.counts[k] > 0);
  const traces = [{
    x: used.map(k => x[k]), y: used.map(k => h.bins.counts[k] / unit), type: 'scatter', mode: 'markers', name: 'bounces', bars: '± Poisson standard error',
    error_y: {type: 'data', array: used.map(k => Math.sqrt(h.bins.counts[k]) / unit), thickness: 1, width: 0, color: grey},
    marker: {size: 4.5, color: blue}, text: used.map(k => h.bins.counts[k]), hovertemplate: 'ε = %{x:.4f}<br>%{text} samples<extra></extra>',
  }];
  if (h.normal) traces.push({x, y: h.normal.expected.map(n => n / unit), type: 'scatter', mode: 'lines', name: 'normal distribution that fits best', line: {color: grey, width: 1.2, dash: 'dot'}, hoverinfo: 'skip'});
  if (h.curve && h.curve.eps)
    traces.push({x: h.curve.eps, y: h.curve.density, type: 'scatter', mode: 'lines', name: 'two exponentials, fitted', line: {color: red, width: 1.8}, hoverinfo: 'skip'});
  const theory = expectedDensity(h);
  if (theory) {
    const simulated = x.map((_, k) => k).filter(k => theory.simulated_counts[k] > 0);
    traces.push({x: simulated.map(k => x[k]), y: simulated.map(k => theory.simulated_counts[k] / (theory.n_simulated * width)), type: 'scatter', mode: 'markers', name: 'simulated, without sound',
                 marker: {size: 9, color: ink, symbol: 'circle-open', line: {width: 1}}, text: simulated.map(k => theory.simulated_counts[k]), hovertemplate: 'ε = %{x:.4f}<br>%{text} simulated<extra></extra>'},
                {x: theory.eps, y: theory.density, type: 'scatter', mode: 'lines', name: 'closed form, nothing fitted', line: {color: green, width: 1.8, dash: 'dash'}, hoverinfo: 'skip'});
  }
  const floor = 0.4 / unit;
  const top = Math.max(...h.bins.counts.map(c => c / unit), ...((h.curve && h.curve.density) || [0]));
  draw(parent, 'small', traces, {
    showlegend: false, margin: {l: 52, r: 8, t: 30, b: 42}, title: {text: `v = ${speed(h.v_mps)}, n = ${number(h.n)}`, font: {size: 13}, x: 0.5, y: 0.97},
    xaxis: axis('coefficient of restitution ε', {nticks: 5}), yaxis: axis('probability density p(ε)', {type: 'log', range: [Math.log10(floor), Math.log10(top) + 0.25], dtick: 1, exponentformat: 'power'}),
  });
}

const errorsOf = (list, color) => ({
  type: 'data', symmetric: false, array: list.map(e => e.ci95 ? e.ci95[1] - e.value : null), arrayminus: list.map(e => e.ci95 ? e.value - e.ci95[0] : null),
  thickness: 1.2, width: 3, color});

/// Slopes without sound, where there are any: of the simulation, or from its true times.
function slopesWithoutSound() {
  if (data.simulation)
    return (data.simulation.histograms || []).filter(h => h.slope_rising && h.slope_falling)
        .map(h => ({v_mps: h.v_mps, rising: h.slope_rising, falling: h.slope_falling}));
  return ((summary && summary.slopes) || []).map(s => ({v_mps: s.v_mps, ...s.from_true_times})).filter(s => s.rising && known(s.rising.value) && s.falling && known(s.falling.value));
}

/// Slopes of p(eps) and their ratio against speed.
/// @param theory  of the simulation: lines; null for recordings
function drawSlopes(parent, histograms, theory) {
  const used = histograms.filter(h => h.slope_rising && h.slope_falling && h.slope_ratio);
  const v = used.map(h => h.v_mps);
  const trace = (key, name, color) => ({x: v, y: used.map(h => h[key].value), mode: 'markers', type: 'scatter', name, bars: '95 %', marker: {size: 7, color},
                                        error_y: errorsOf(used.map(h => h[key]), color), hovertemplate: `%{x} m/s<br>${name} %{y:.4g}<extra></extra>`});
  const expected = (theory && theory.slopes) || [], other = theory ? slopesWithoutSound() : [];
  const line = (side, color) => ({x: expected.map(s => s.v_mps), y: expected.map(s => s[side]), mode: 'lines', type: 'scatter', name: `${side}, theory`, line: {color, width: 1.6},
                                  hovertemplate: `%{x} m/s<br>${side}, theory %{y:.4g}<extra></extra>`});
  const open = (side, color) => ({x: other.map(s => s.v_mps), y: other.map(s => s[side].value), mode: 'markers', type: 'scatter', name: `${side}, without sound`, showlegend: false,
                                  marker: {size: 12, color, symbol: 'circle-open', line: {width: 1.4}}, hovertemplate: `%{x} m/s<br>${side}, without sound %{y:.4g}<extra></extra>`});
  const lines = expected.length ? [line('rising', blue), line('falling', orange)] : [];
  const rings = other.length ? [open('rising', blue), open('falling', orange)] : [];
  draw(parent, 'low', [...lines, ...rings, trace('slope_rising', theory && !narrow ? 'rising, sound' : 'rising', blue), trace('slope_falling', theory && !narrow ? 'falling, sound' : 'falling', orange)],
       {showlegend: true, xaxis: speedAxis(), yaxis: logAxis('slope of log p(ε)')});
  const ratio = expected.length ? [{x: expected.map(s => s.v_mps), y: expected.map(s => s.falling / s.rising), mode: 'lines', type: 'scatter', name: 'falling / rising, theory', line: {color: ink, width: 1.6}, hoverinfo: 'skip'}] : [];
  draw(parent, 'low', [...ratio, trace('slope_ratio', 'falling / rising', ink)],
       {showlegend: false, xaxis: speedAxis(), yaxis: axis('falling slope / rising slope'),
        shapes: [{type: 'line', xref: 'paper', x0: 0, x1: 1, y0: 1, y1: 1, line: {color: red, width: 1.4}}]});
}

/// Scatter of eps against speed, with its power law.
function drawEnergy(parent, budget) {
  const rows = budget.rows, v = rows.map(r => r.v_mps);
  const points = (key, name, color, symbol) => ({x: v, y: rows.map(r => r[key]), mode: 'markers', type: 'scatter', name, marker: {size: 8, color, symbol},
                                                 hovertemplate: `%{x:.3f} m/s<br>${name} %{y:.3e}<extra></extra>`});
  const traces = [points('spread', 'all of it', ink, 'circle'), points('spread_asperities', 'of the ball (fit)', blue, 'diamond'),
                  points('spread_timing_stated', 'timing, as stated', orange, 'triangle-up'), points('spread_timing_lag1', 'timing, from neighbours', green, 'triangle-down')]
      .filter(t => t.y.some(y => known(y) && y > 0));
  if (budget.width_exponent)
    traces.push({x: budget.width_law.v_mps, y: budget.width_law.spread, mode: 'lines', type: 'scatter', line: {color: red, width: 1.6}, hoverinfo: 'skip',
                 name: `v^(${measured(budget.width_exponent.value, budget.width_exponent.se)})`});
  draw(parent, '', traces, {showlegend: true, xaxis: speedAxis(), yaxis: logAxis('standard deviation of ε', decadesIfMany(traces))});
}

const causes = [['share_asperities', 'ball (asperities)', blue], ['share_timing', 'timing', orange], ['share_travel_time', 'travel time', green], ['share_unexplained', 'not explained', grey]];
const shifts = [['shift_drag', 'air drag', blue], ['shift_contact_time', 'contact time', orange]];
const shiftsOf = budget => shifts.filter(([key]) => budget.rows.some(r => known(r[key]) && r[key] !== 0));

/// Where the variance of eps comes from, and what shifts eps(v), by speed.
function drawBudget(parent, budget) {
  const rows = budget.rows, names = rows.map(r => number(r.v_mps, 2));
  draw(parent, 'low', causes.filter(([key]) => rows.some(r => known(r[key]) && r[key] > 0)).map(([key, name, color]) => (
         {type: 'bar', x: names, y: rows.map(r => 100 * (r[key] || 0)), name, marker: {color}, hovertemplate: `%{x} m/s<br>${name} %{y:.2f}%<extra></extra>`})),
       {barmode: 'stack', showlegend: true, xaxis: axis('normal impact speed v (m/s)', {type: 'category'}), yaxis: axis('share of variance (%)')});
  const traces = shiftsOf(budget).map(([key, name, color]) => (
      {x: rows.map(r => r.v_mps), y: rows.map(r => known(r[key]) && r[key] !== 0 ? Math.abs(r[key]) : null), mode: 'lines+markers', type: 'scatter', name, line: {color, width: 1.5},
       marker: {size: 6}, text: rows.map(r => number(r[key], 3)), hovertemplate: `%{x:.3f} m/s<br>${name} %{text}<extra></extra>`}));
  if (traces.length) draw(parent, 'low', traces, {showlegend: true, xaxis: speedAxis(), yaxis: logAxis('shift of ε(v)', decadesIfMany(traces))});
}
