// SPDX-License-Identifier: GPL-3.0-or-later
// The paper, whole: its figures from the simulation and from the sound, side by side, and what it concludes.

const below = {orientation: 'h', y: narrow ? -0.24 : -0.18, yanchor: 'top', x: 0, font: {size: 11}, itemsizing: 'constant'};  // a legend that leaves the buttons alone
const windowColours = ['#0b2545', '#1f5fa8', '#3a86c8', '#5aa9a0', '#8ab06a', '#d9a22b', '#d9722b', '#c0392b'];

function twoPlaces(name, title, caption) {
  const parent = figure(name, title, caption);
  parent.classList.add('pair');
  return parent;
}

/// Top of figs. 1 and 2: how often which eps was found at which speed, as a share of the most frequent cell.
function drawPaperDensity(parent, title, fitted, ranges) {
  const most = Math.max(...fitted.density.counts.flat());
  const z = fitted.density.counts.map(row => row.map(n => n > 0 ? Math.log10(n / most) : null));
  const ticks = [0, -1, -2, -3, -4].filter(t => 10 ** t * most >= 1);
  const traces = [{type: 'heatmap', x: centres(fitted.density.v_edges_mps), y: centres(fitted.density.eps_edges), z, zmin: ranges.floor, zmax: 0,
                   text: fitted.density.counts, colorscale: depth, hovertemplate: 'v = %{x:.3f} m/s<br>ε = %{y:.4f}<br>%{text} samples<extra></extra>',
                   colorbar: {title: {text: 'relative frequency', side: 'right'}, tickvals: ticks, ticktext: ticks.map(t => t === 0 ? '1' : `10<sup>${t}</sup>`), thickness: 10, len: 0.9}}];
  if (summary && summary.truth_curve)
    traces.push({x: summary.truth_curve.map(p => p.v_mps), y: summary.truth_curve.map(p => p.eps), mode: 'lines', type: 'scatter', name: 'the law that went in',
                 line: {color: red, width: 1.6}, hoverinfo: 'skip'});
  draw(parent, '', traces, {showlegend: false, title: {text: title, font: {size: 14}, x: 0.02, xanchor: 'left', y: 0.975, yanchor: 'top'}, margin: {l: 62, r: 8, t: 56, b: 48},
                            xaxis: axis('normal impact speed v (m/s)', {range: ranges.v}), yaxis: axis('coefficient of restitution ε', {range: ranges.eps})});
}

/// Bottom of figs. 1 and 2: the histograms of all windows with their exponentials.
function drawPaperHistograms(parent, title, fitted, range) {
  const traces = [];
  fitted.histograms.filter(h => h.bins && h.bins.counts.length).forEach((h, k) => {
    const width = h.bins.eps_edges[1] - h.bins.eps_edges[0], x = centres(h.bins.eps_edges);
    const used = x.map((_, i) => i).filter(i => h.bins.counts[i] > 0);
    const color = windowColours[k % windowColours.length], name = `${number(h.v_mps, 2)} m/s`;
    traces.push({x: used.map(i => x[i]), y: used.map(i => h.bins.counts[i] / (h.n * width)), type: 'scatter', mode: 'markers', name, legendgroup: name,
                 marker: {size: 3.5, color}, hovertemplate: `${name}<br>ε = %{x:.4f}<br>p = %{y:.3g}<extra></extra>`});
    if (h.curve && h.curve.eps)
      traces.push({x: h.curve.eps, y: h.curve.density, type: 'scatter', mode: 'lines', legendgroup: name, name: `${name}, fitted`, showlegend: false, line: {color, width: 1.4}, hoverinfo: 'skip'});
    const theory = expectedDensity(h);
    if (theory) traces.push({x: theory.eps, y: theory.density, type: 'scatter', mode: 'lines', legendgroup: name, name: `${name}, closed form`, showlegend: false, line: {color: ink, width: 1, dash: 'dash'}, hoverinfo: 'skip'});
  });
  draw(parent, '', traces, {title: {text: title, font: {size: 14}, x: 0.02, xanchor: 'left', y: 0.975, yanchor: 'top'}, margin: {l: 62, r: 8, t: 56, b: 96}, showlegend: true,
                            legend: below,
                            xaxis: axis('coefficient of restitution ε', {range: range.eps}), yaxis: axis('probability density p(ε)', {type: 'log', range: range.p, dtick: 1, exponentformat: 'power'})});
}

/// The scatter against the speed: what asperities make, what hearing adds, what a smooth ball leaves.
function drawSpread(parent, spread) {
  const sources = [['simulation', spread.simulation, ink, 'circle-open'], ['sound', spread.sound, blue, 'circle'], ['smooth ball, sound', spread.smooth_ball, orange, 'diamond']];
  const traces = sources.filter(([, s]) => s && s.v_mps.length).map(([name, s, color, symbol]) => (
    {x: s.v_mps, y: s.spread, name, type: 'scatter', mode: 'lines+markers', line: {color, width: 1.2}, marker: {color, symbol, size: 8},
     hovertemplate: `${name}<br>v = %{x:.3f} m/s<br>spread %{y:.3g}<extra></extra>`}));
  const s = spread.simulation;
  if (s && s.v_mps.length) {
    const middle = s.v_mps.length >> 1;
    traces.push({x: s.v_mps, y: s.v_mps.map(v => s.spread[middle] * s.v_mps[middle] / v), name: '1/v', type: 'scatter', mode: 'lines',
                 line: {color: grey, dash: 'dash', width: 1.4}, hoverinfo: 'skip'});
  }
  const exponent = e => e ? measured(e.value, e.se) : '–';
  draw(parent, '', traces, {showlegend: true, legend: below, margin: {l: 66, r: 10, t: 40, b: 96},
                            xaxis: axis('normal impact speed v (m/s)', {type: 'log', tickvals: [0.1, 0.2, 0.3, 0.5, 0.7, 1, 1.4]}), yaxis: axis('standard deviation of ε', {type: 'log', dtick: 1, exponentformat: 'power'})});
  add('p', {class: 'caption'}, `Exponent k of spread ∝ v^k: simulation ${exponent(spread.simulation.exponent)}, sound ${exponent(spread.sound.exponent)}.`);
}

/// Where the energy goes, bounce by bounce.
function drawShares(parent, s) {
  const line = (name, y, color) => ({x: s.impact, y, name, type: 'scatter', mode: 'lines', line: {color, width: 2}, hovertemplate: `${name}<br>bounce %{x}<br>%{y:.4f}<extra></extra>`});
  const traces = [
    {x: s.impact.concat([...s.impact].reverse()), y: s.rotational_hi.concat([...s.rotational_lo].reverse()), fill: 'toself', fillcolor: 'rgba(31,95,168,.18)',
     line: {width: 0}, hoverinfo: 'skip', name: 'rotational, 16–84% of drops', type: 'scatter', mode: 'lines'},
    line('vertical', s.vertical, ink), line('horizontal', s.horizontal, orange), line('rotational', s.rotational, blue)];
  draw(parent, '', traces, {showlegend: true, legend: below, margin: {l: 62, r: 10, t: 40, b: 96}, xaxis: axis('number of the bounce'), yaxis: axis('share of the kinetic energy', {type: 'log', exponentformat: 'power', dtick: 1})});
}

function conclusionsTable(conclusions) {
  add('h2', {}, 'What the paper concludes, put to the numbers of this run');
  const value = c => known(c.value) ? number(c.value, 4) + (c.ci95 ? ` (${number(c.ci95[0], 4)} to ${number(c.ci95[1], 4)})` : '') : '–';
  const scroll = scrollPlace('What the paper concludes');
  page.append(scroll);
  scroll.append(element('table', {class: 'words'},
      element('thead', {}, element('tr', {}, ['verdict', 'claim', 'measured', 'value (95%)', 'holds if', 'detail'].map(headCell))),
      element('tbody', {}, conclusions.map(c => element('tr', {}, [element('td', {class: c.holds ? 'yes' : 'no'}, c.holds ? 'holds' : 'does not hold'),
          element('td', {class: 'text'}, c.claim), element('td', {class: 'text'}, c.measure), element('td', {class: 'value'}, value(c)), ...[c.criterion, c.detail].map(t => element('td', {class: 'text'}, t))])))));
}

function paperSlopes(windows) {
  const expected = (summary && summary.theory && summary.theory.slopes) || [];
  const theory = (w, side) => expected.length ? [number(Math.round((expected.find(s => Math.abs(s.v_mps - w.v_mps) < 1e-9) || {})[side]))] : [];
  const row = (head, w, side) => [...head, side, ...theory(w, side), measured(w[side].simulation.value, w[side].simulation.se), measured(w[side].sound.value, w[side].sound.se), w[side].ratio.toFixed(3)];
  table('Slopes of p(ε): what measuring by sound adds', ['window', 'n simulation', 'n sound', 'side', ...(expected.length ? ['theory'] : []), 'simulation', 'sound', 'ratio'],
        windows.flatMap(w => [row([`${number(w.v_mps, 2)} m/s`, number(w.n_simulation), number(w.n_sound)], w, 'rising'), row(['', '', ''], w, 'falling')]));
  add('p', {class: 'caption'}, 'Slopes per unit of ε, with standard errors. Simulation: macroscopic ε of every impact. Sound: eq. 2 on the times detected, the stated timing noise taken out. Ratio: sound over simulation.' + (expected.length ? ' Theory: the closed form of docs/physics.md, section 7, for the surface simulated; no parameter is fitted.' : ''));
}

/// Everything above, where paper.json is in the folder.
function paperSection(paper, simulation) {
  conclusionsTable(paper.conclusions);
  const both = [simulation, fit];
  const densities = both.map(f => f.density);
  const ranges = {v: [Math.min(...densities.map(d => d.v_edges_mps[0])), Math.max(...densities.map(d => d.v_edges_mps.at(-1)))],
                  eps: [Math.min(...densities.map(d => d.eps_edges[0])), Math.max(...densities.map(d => d.eps_edges.at(-1)))],
                  floor: -Math.ceil(Math.log10(Math.max(10, ...densities.map(d => Math.max(...d.counts.flat())))))};
  const pictures = twoPlaces('paper-law', 'Coefficient of restitution against impact speed: simulated, and detected in its sound',
                             'As figures 4 (simulation) and 1 (experiment) of the paper, top. Colour: frequency relative to the most frequent cell, logarithmic; the same axes. Line: the law that went in.');
  drawPaperDensity(pictures, 'simulation: macroscopic ε', simulation, ranges);
  drawPaperDensity(pictures, 'sound: eq. 2 on the times detected', fit, ranges);
  const bins = both.flatMap(f => f.histograms.filter(h => h.bins && h.bins.counts.length));
  if (bins.length) {
    const heights = bins.flatMap(h => h.bins.counts.filter(c => c > 0).map(c => Math.log10(c / (h.n * (h.bins.eps_edges[1] - h.bins.eps_edges[0])))));
    const range = {eps: [Math.min(...bins.map(h => h.bins.eps_edges[0])), Math.max(...bins.map(h => h.bins.eps_edges.at(-1)))], p: [Math.min(...heights) - 0.1, Math.max(...heights) + 0.2]};
    const histogramsPlace = twoPlaces('paper-histograms', 'Distribution of ε at fixed speed: simulated, and detected in its sound',
                                      'As figures 4 (simulation) and 1 (experiment) of the paper, bottom: normalised frequency in windows of speed; lines: two exponentials each, fitted. The same axes.' +
                                      (bins.some(expectedDensity) ? ' Dashes: the closed form for the surface simulated, in both pictures the same; no parameter is fitted.' : ''));
    drawPaperHistograms(histogramsPlace, 'simulation', simulation, range);
    drawPaperHistograms(histogramsPlace, 'sound', fit, range);
  }
  if (paper.slopes.length) paperSlopes(paper.slopes);
  const why = twoPlaces('paper-why', 'Why it scatters', 'Left: standard deviation of ε about the law in bins of speed; what a smooth ball leaves is the method’s own noise. Right: mean shares of the kinetic energy just before each bounce.');
  drawSpread(why, paper.spread);
  drawShares(why, paper.energy_shares);
}
