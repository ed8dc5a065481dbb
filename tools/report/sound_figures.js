// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of the recording.


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

function drawSound() {
  const parent = figure('sound', 'The sound and the impacts found in it', `${wave.recording || ''}, ${number(wave.rate_hz)} Hz, channel ${wave.channel}. ` +
                        'Grey: extremes of the recording; marks on top: impacts. Below: excerpts with the time found (line) and its standard error (band).');
  drawWave(parent);
  const grid = element('div', {class: 'grid'});
  parent.append(grid);
  for (const excerpt of wave.excerpts || []) drawExcerpt(grid, excerpt);
}
