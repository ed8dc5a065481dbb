// SPDX-License-Identifier: GPL-3.0-or-later
// A look inside the detection: for each recording the learned wave and the noise, for each drop its sound and its intervals.

function drawLearnedWave(parent, learned) {
  const ms = learned.mean.map((_, k) => 1e3 * (learned.t0_s + k * learned.dt_s));
  const edge = sign => learned.mean.map((m, k) => m + sign * learned.spread[k]);
  draw(parent, 'small', [
    {x: ms.concat([...ms].reverse()), y: edge(1).concat(edge(-1).reverse()), fill: 'toself', fillcolor: 'rgba(31,95,168,.25)', line: {width: 0}, hoverinfo: 'skip', type: 'scatter', mode: 'lines', name: 'spread from impact to impact'},
    {x: ms, y: learned.mean, type: 'scatter', mode: 'lines', name: 'learned wave', line: {color: ink, width: 1}, hovertemplate: '%{x:.4f} ms<extra></extra>'}],
    {showlegend: false, margin: {l: 62, r: 8, t: 30, b: 42}, title: {text: `learned wave, of ${number(learned.n_impacts)} impacts`, font: {size: 13}, x: 0.5, y: 0.97},
     shapes: [{type: 'line', x0: 0, x1: 0, yref: 'paper', y0: 0, y1: 1, line: {color: red, width: 1.2}}], xaxis: axis('time after the start of contact (ms)', {nticks: 6}), yaxis: axis('amplitude (full scale = 1)')});
}

function drawNoise(parent, noise) {
  draw(parent, 'small', [{x: noise.frequency_hz, y: noise.psd, type: 'scatter', mode: 'lines', name: 'noise', line: {color: blue, width: 1.3}, hovertemplate: '%{x:.0f} Hz<br>%{y:.3g} /Hz<extra></extra>'}],
       {showlegend: false, margin: {l: 70, r: 8, t: 30, b: 42}, title: {text: 'noise of the quiet parts', font: {size: 13}, x: 0.5, y: 0.97},
        xaxis: axis('frequency (Hz)', {type: 'log'}), yaxis: axis('spectral density (1/Hz)', {type: 'log', exponentformat: 'power'})});
}

function drawDropSound(parent, drop) {
  const e = drop.envelope, level = 1.1 * Math.max(...e.hi.map(Math.abs), ...e.lo.map(Math.abs), 1e-12);
  const marks = (list, color, name) => ({x: list.map(m => m.t_s), y: list.map(() => level), mode: 'markers', type: 'scatter', name,
    marker: {symbol: 'line-ns', size: 9, line: {width: 1.2, color}}, text: list.map(m => `impact ${m.impact}${m.flags ? ', ' + m.flags : ''}`), hovertemplate: '%{x:.6f} s<br>%{text}<extra></extra>'});
  draw(parent, 'small', [
    {x: e.t_s, y: e.lo, mode: 'lines', type: 'scatter', line: {width: 0.6, color: grey}, hoverinfo: 'skip'},
    {x: e.t_s, y: e.hi, mode: 'lines', type: 'scatter', line: {width: 0.6, color: grey}, fill: 'tonexty', fillcolor: 'rgba(120,132,145,.45)', name: 'sound', hoverinfo: 'skip'},
    marks(drop.marks.filter(m => !m.flags), red, 'impacts found'), marks(drop.marks.filter(m => m.flags), orange, 'impacts with a flag')],
    {showlegend: false, margin: {l: 56, r: 8, t: 30, b: 42}, title: {text: 'sound and marks (orange: with a flag)', font: {size: 13}, x: 0.5, y: 0.97}, xaxis: axis('time (s)'), yaxis: axis('amplitude (full scale = 1)', {nticks: 5})});
}

/// Found less expected: what the law at this speed does not explain, asperities and timing together.
function drawIntervals(parent, i) {
  const used = i.impact.map((_, k) => k).filter(k => known(i.expected_s[k]));
  draw(parent, 'small', [{x: used.map(k => i.impact[k]), y: used.map(k => 1e6 * (i.found_s[k] - i.expected_s[k])), type: 'scatter', mode: 'markers', name: 'interval', bars: '± standard error of timing', marker: {size: 5, color: blue},
                          error_y: {type: 'data', array: used.map(k => known(i.sigma_s[k]) ? 1e6 * i.sigma_s[k] : 0), thickness: 1, width: 0, color: grey},
                          text: used.map(k => `found ${(1e3 * i.found_s[k]).toFixed(4)} ms, expected ${(1e3 * i.expected_s[k]).toFixed(4)} ms`), hovertemplate: 'after impact %{x}<br>%{text}<extra></extra>'}],
       {showlegend: false, margin: {l: 66, r: 8, t: 30, b: 42}, title: {text: 'intervals: found less expected', font: {size: 13}, x: 0.5, y: 0.97},
        xaxis: axis('interval after impact'), yaxis: axis('found less expected (µs)', {zeroline: true, zerolinecolor: red, zerolinewidth: 1.2})});
}

function diagnosticsSection(diagnostics) {
  for (const r of diagnostics.recordings) {
    const parent = figure('inside', `A look inside: ${r.recording}`, 'The wave learned from the recording’s own impacts, with its spread from impact to impact, and the noise it is weighed against. Below, drop by drop: sound and marks, ' +
                          'the intervals found less those that the fitted law expects (bars: timing error alone), and some impacts with the time found and its error.');
    const common = element('div', {class: 'grid'});
    parent.append(common);
    if (r.wave) drawLearnedWave(common, r.wave);
    if (r.noise) drawNoise(common, r.noise);
    r.drops.forEach((drop, k) => {
      parent.append(element('h3', {}, `drop ${drop.marks.length ? drop.marks[0].drop : k}: ${number(drop.marks.length)} impacts`));
      const grid = element('div', {class: 'grid'});
      parent.append(grid);
      drawDropSound(grid, drop);
      if (drop.intervals.impact.length) drawIntervals(grid, drop.intervals);
      for (const excerpt of drop.excerpts) drawExcerpt(grid, excerpt);
    });
    if (r.n_drops > r.drops.length) add('p', {class: 'caption'}, `${number(r.n_drops - r.drops.length)} more drops are not shown.`);
  }
}
