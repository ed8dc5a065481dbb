// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of eps(v): density and curve; of the law: residuals, corners.


function band(curve, color, name) {
  const v = curve.map(p => p.v_mps);
  return {x: v.concat([...v].reverse()), y: curve.map(p => p.hi95).concat(curve.map(p => p.lo95).reverse()), fill: 'toself',
          fillcolor: color, line: {width: 0}, hoverinfo: 'skip', name, type: 'scatter', mode: 'lines'};
}
function centres(edges) { return edges.slice(1).map((right, k) => 0.5 * (right + edges[k])); }

/// The values of ε that matter: those within four standard deviations of a bounce about the curve, and its band.
function epsRange() {
  const curve = answerCurve(fit);
  if (!few || !curve.length || !(fit.curve.scatter > 0)) return null;
  const reach = 4 * fit.curve.scatter, within = samples.eps.filter((eps, k) => Math.abs(eps - nearest(curve, samples.v_mps[k]).eps) <= reach);
  const all = [...within, ...curve.flatMap(p => [p.lo95, p.hi95, p.eps])].filter(known), lo = Math.min(...all), hi = Math.max(...all), margin = 0.06 * (hi - lo || 0.01);
  return [lo - margin, hi + margin];
}
const nearest = (curve, v) => curve.reduce((best, p) => Math.abs(Math.log(p.v_mps / v)) < Math.abs(Math.log(best.v_mps / v)) ? p : best);

function samplesTrace() {
  if (few) {
    const range = epsRange(), inside = samples.eps.map(eps => !range || (eps >= range[0] && eps <= range[1])), shown = list => list.filter((_, k) => inside[k]);
    return {x: shown(samples.v_mps), y: shown(samples.eps), mode: 'markers', type: 'scatter', name: 'bounces',
            error_y: {type: 'data', array: shown(samples.sigma_eps), thickness: 1, width: 0, color: grey},
            marker: {size: 6, color: blue}, hovertemplate: 'v = %{x:.4f} m/s<br>ε = %{y:.5f}<extra></extra>'};
  }
  const {counts, v_edges_mps, eps_edges} = fit.density;
  const z = counts.map(row => row.map(n => n > 0 ? Math.log10(n) : null));
  const most = Math.max(1, Math.ceil(Math.max(...counts.flat().map(n => n > 0 ? Math.log10(n) : 0))));
  const ticks = [...Array(most + 1).keys()];
  return {type: 'heatmap', name: 'bounces', x: centres(v_edges_mps), y: centres(eps_edges), z, text: counts, zmin: 0, colorscale: depth,
          colorbar: {title: {text: 'bounces', side: 'right'}, tickvals: ticks, ticktext: ticks.map(t => number(10 ** t)), thickness: 12, len: 0.9},
          hovertemplate: 'v = %{x:.3f} m/s<br>ε = %{y:.4f}<br>%{text} bounces<extra></extra>'};
}

/// Bounces beyond the range that is drawn, as arrows at its ends.
function beyondTraces(range) {
  if (!range) return [];
  const beyond = (far, y, symbol, side) => {
    const k = samples.eps.map((_, i) => i).filter(i => far(samples.eps[i]));
    return k.length ? [{x: k.map(i => samples.v_mps[i]), y: k.map(() => y), mode: 'markers', type: 'scatter', name: `${k.length} ${side}`, cliponaxis: false,
                        marker: {size: 10, color: blue, symbol}, text: k.map(i => samples.eps[i].toFixed(3)), hovertemplate: 'v = %{x:.4f} m/s<br>ε = %{text}<extra></extra>'}] : [];
  };
  return [...beyond(eps => eps > range[1], range[1], 'triangle-up', 'above'), ...beyond(eps => eps < range[0], range[0], 'triangle-down', 'below')];
}

/// ε of each plate or recording at its own speeds, where they differ; of more than six colours tell nothing.
function ownTraces() {
  const own = (fit.recordings || []).filter(r => (r.nodes || []).length);
  return own.length > 6 ? [] : own.map((r, k) => ({x: r.nodes.map(n => n.v_mps), y: r.nodes.map(n => n.eps), mode: 'lines+markers', type: 'scatter', name: shownName(r.recording) || '(no name)', bars: '95 %',
    error_y: {type: 'data', symmetric: false, array: r.nodes.map(n => n.ci95 ? n.ci95[1] - n.eps : null), arrayminus: r.nodes.map(n => n.ci95 ? n.eps - n.ci95[0] : null), thickness: 1.4, width: 4, color: ownColour(k)},
    line: {color: ownColour(k), width: 1.6}, marker: {size: 8, color: ownColour(k), line: {color: 'white', width: 1}}, hovertemplate: 'v = %{x:.3f} m/s<br>ε = %{y:.5f}<extra></extra>'}));
}
const ownColour = k => [red, orange, green, ink, blue, grey][k];

/// Figure 1 (top) of the paper: how often which eps was found at which speed, with the law.
function drawLaw(parent) {
  const traces = few || (fit && fit.density && fit.density.counts.length) ? [samplesTrace()] : [];
  const curve = answerCurve(fit);
  if (curve && curve.length) {
    if (known(curve[0].lo95)) traces.push(band(curve, 'rgba(192,57,43,.22)', '95 % range'));
    traces.push({x: curve.map(p => p.v_mps), y: curve.map(p => p.eps), mode: 'lines', type: 'scatter', name: 'ε(v)',
                 line: {color: red, width: 2}, hovertemplate: 'v = %{x:.3f} m/s<br>ε(v) = %{y:.5f}<extra></extra>'});
  }
  if (summary && summary.truth_curve)
    traces.push({x: summary.truth_curve.map(p => p.v_mps), y: summary.truth_curve.map(p => p.eps), mode: 'lines', type: 'scatter',
                 name: 'what went in', line: {color: ink, width: 1.6, dash: 'dash'},
                 hovertemplate: 'v = %{x:.3f}<br>truth %{y:.5f}<extra></extra>'});
  if (fit && fit.is_one_ball === false) traces.push(...ownTraces());
  const peaks = ((fit && fit.is_one_ball !== false && fit.histograms) || []).filter(h => h.peak_eps && known(h.peak_eps.value));
  if (!few && peaks.length)
    traces.push({x: peaks.map(h => h.v_mps), y: peaks.map(h => h.peak_eps.value), mode: 'markers', type: 'scatter', name: 'most frequent ε',
                 error_y: {type: 'data', array: peaks.map(h => h.peak_eps.se), thickness: 1.4, width: 3, color: orange},
                 marker: {color: orange, size: 7, line: {color: 'white', width: 1}}, hovertemplate: 'v = %{x:.2f}<br>peak %{y:.5f}<extra></extra>'});
  const range = fit && fit.density && !few ? [fit.density.eps_edges[0], fit.density.eps_edges.at(-1)] : epsRange() ?? undefined;
  if (few) traces.push(...beyondTraces(range));
  draw(parent, '', traces, {xaxis: axis('normal impact speed v (m/s)'), yaxis: axis('coefficient of restitution ε', {range}), showlegend: true});
}

/// Does the law hold at every speed? Pulls of the location, and the width of the scatter, in bins of speed.
function drawResiduals(parent, residuals) {
  const used = residuals.filter(r => known(r.pull));
  const trace = (key, extra) => Object.assign({x: used.map(r => r.v_mps), y: used.map(r => r[key]), mode: 'markers', type: 'scatter', name: 'bin of speed',
                                               marker: {size: 7, color: blue}, text: used.map(r => r.n)}, extra);
  draw(parent, 'low', [trace('pull', {error_y: {type: 'constant', value: 1, thickness: 1, width: 0, color: grey},
                                      hovertemplate: 'v = %{x:.3f} m/s<br>pull %{y:.2f}<br>%{text} samples<extra></extra>'})],
       {showlegend: false, xaxis: axis('normal impact speed v (m/s)'), yaxis: axis('pull of the law<br>(standard errors)', {zeroline: true, zerolinecolor: red, zerolinewidth: 1.4})});
  // mean distances of n exponentially distributed samples are known to 1/sqrt(n)
  draw(parent, 'low', [trace('scatter_ratio', {error_y: {type: 'data', array: used.map(r => r.scatter_ratio / Math.sqrt(r.n)), thickness: 1, width: 0, color: grey},
                                               hovertemplate: 'v = %{x:.3f} m/s<br>%{y:.3f} of the scatter expected<br>%{text} samples<extra></extra>'})],
       {showlegend: false, xaxis: axis('normal impact speed v (m/s)'), yaxis: axis('scatter found / fitted'),
        shapes: [{type: 'line', xref: 'paper', x0: 0, x1: 1, y0: 1, y1: 1, line: {color: red, width: 1.4}}]});
}

/// Ellipse of a pair of normal estimates that a point falls into with probability 68 or 95 % (chi2 of two degrees).
function ellipse(a, b, correlation, chi2) {
  const angles = [...Array(73).keys()].map(k => 2 * Math.PI * k / 72), r = Math.sqrt(chi2), s = Math.sqrt(Math.max(0, 1 - correlation * correlation));
  return {x: angles.map(t => a.value + a.se * r * Math.cos(t)), y: angles.map(t => b.value + b.se * r * (correlation * Math.cos(t) + s * Math.sin(t)))};
}
function bell(e) {
  const x = [...Array(81).keys()].map(k => e.value + e.se * (k - 40) / 11);
  return {x, y: x.map(t => Math.exp(-0.5 * ((t - e.value) / e.se) ** 2))};
}

const constantAxis = name => name === 'gamma' ? 'γ ((s/m)<sup>1/5</sup>)' : name.replace(/^A(\d+)$/, (_, i) => `A<sub>${i}</sub> ((s/m)<sup>${i}/10</sup>)`);

/// What is known of each constant alone (diagonal: normal of its standard error, bar: 95 % interval) and of each pair.
function drawCorner(parent, estimates, correlation) {
  const n = estimates.length, traces = [], plotLayout = {showlegend: false, grid: {rows: n, columns: n, pattern: 'independent'}, shapes: []};
  const cell = (row, column) => row * n + column + 1;
  const ranges = estimates.map(e => [e.value - 3.6 * e.se, e.value + 3.6 * e.se]);
  for (let row = 0; row < n; ++row) {
    for (let column = 0; column <= row; ++column) {
      const id = cell(row, column), axes = {xaxis: 'x' + id, yaxis: 'y' + id, type: 'scatter', mode: 'lines', hoverinfo: 'skip'};
      const a = estimates[column], b = estimates[row];
      const common = {nticks: 4, tickfont: {size: narrow ? 8 : 11}, tickangle: 0, exponentformat: 'none', separatethousands: false};
      plotLayout['xaxis' + id] = axis(row === n - 1 ? constantAxis(a.name) : '', {...common, words: constantAxis(a.name), range: ranges[column], anchor: 'y' + id, showticklabels: row === n - 1,
                                                                    domain: [column / n + 0.03, (column + 1) / n - 0.02]});
      plotLayout['yaxis' + id] = axis(column === 0 && row > 0 ? constantAxis(b.name) : '', {
        ...common, words: row === column ? 'relative probability' : constantAxis(b.name), anchor: 'x' + id, showticklabels: column === 0 && row > 0, range: row === column ? [0, 1.15] : ranges[row],
        domain: [1 - (row + 1) / n + 0.03, 1 - row / n - 0.02]});
      if (row === column) {
        traces.push({...axes, ...bell(a), name: 'normal of the standard error', line: {color: blue, width: 1.8}});
        if (a.ci95) traces.push({...axes, x: a.ci95, y: [0.05, 0.05], name: '95 % interval', line: {color: ink, width: 4}});
        if (known(a.truth)) traces.push({...axes, x: [a.truth, a.truth], y: [0, 1.1], name: 'what went in', line: {color: red, width: 1.4, dash: 'dash'}});
        continue;
      }
      traces.push({...axes, ...ellipse(a, b, correlation[row][column], 5.99), name: '95 % of both', line: {color: blue, width: 1}, fill: 'toself', fillcolor: 'rgba(31,95,168,.15)'});
      traces.push({...axes, ...ellipse(a, b, correlation[row][column], 2.30), name: '68 % of both', line: {color: blue, width: 1.4}, fill: 'toself', fillcolor: 'rgba(31,95,168,.35)'});
      if (known(a.truth) && known(b.truth))
        traces.push({...axes, x: [a.truth], y: [b.truth], name: 'what went in, of both', mode: 'markers', marker: {symbol: 'x-thin', size: 9, line: {color: red, width: 2}}});
    }
  }
  draw(parent, 'corner', traces, plotLayout);
}

function cornerOfConstants() {
  const truths = Object.fromEntries(((summary && summary.constants) || []).map(c => [c.name, c.truth])), names = constants.parameters || [];
  const shown = names.filter(isDetermined).map(name => ({name, ...constants[name], truth: truths[name]}));
  if (shown.length < 2 || shown.length < names.length || !shown.every(e => known(e.value) && known(e.se) && e.se > 0)) return;
  drawCorner(figure('constants', `How well ${shown.map(c => c.name).join(', ')} are known`,
                    'Diagonal: each alone, with its 95% interval as a bar. Below: ellipses that hold 68% and 95%.' + (summary && summary.eps_nodes ? ' Red: what went in.' : '') +
                        ' Thin ellipses: only a combination of the constants is known.'), shown,
             constants.covariance.map((row, i) => row.map((c, j) => c / Math.sqrt(constants.covariance[i][i] * constants.covariance[j][j]))));
}
