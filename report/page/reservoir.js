// SPDX-License-Identifier: GPL-3.0-or-later
// "Rotation is the reservoir", measured: what the vertical motion lost, from sound, beside what spin and sideways
// motion hold in the simulation.


const root = list => Math.sqrt(list.reduce((sum, x) => sum + x * x, 0));

/// Sound against simulation, drop by drop; below, their difference with the drop's own error and the band of the law's.
function drawReservoir(parent, r) {
  const d = r.drops, x = d.simulated_m2ps2, difference = x.map((w, k) => d.sound_m2ps2[k] - w);
  const most = Math.max(...x, ...d.sound_m2ps2), least = Math.min(0, ...x, ...d.sound_m2ps2), margin = 0.04 * (most - least), top = most + margin, low = least - margin;
  const many = x.length > 300, marker = {size: many ? 4 : 7, color: blue, opacity: many ? 0.5 : 1};
  const what = d.drop.map((drop, k) => `drop ${drop}, impacts ${d.first_impact[k]} to ${d.last_impact[k]}`);
  draw(parent, '', [
    {x: [low, top], y: [low, top], type: 'scatter', mode: 'lines', name: 'equal', line: {color: ink, width: 1.2, dash: 'dash'}, hoverinfo: 'skip'},
    {x, y: d.sound_m2ps2, type: 'scatter', mode: 'markers', name: 'drop', marker, text: what, hovertemplate: '%{text}<br>simulated %{x:.4g}<br>sound %{y:.4g} m²/s²<extra></extra>'}],
    {showlegend: false, xaxis: axis('twice the energy per mass gained,<br>simulated (m²/s²)', {range: [low, top], nticks: 6}), yaxis: axis('twice the energy per mass gained,<br>from sound (m²/s²)', {range: [low, top], nticks: 6})});
  const traces = [{x, y: difference, type: 'scatter', mode: 'markers', name: 'drop', marker, text: what, error_y: {type: 'data', array: d.own_se_m2ps2, thickness: 1, width: 0, color: grey},
                   hovertemplate: '%{text}<br>sound less simulated %{y:.3g} m²/s²<extra></extra>'}];
  if (known(r.expected_law_m2ps2)) {
    const order = x.map((_, k) => k).sort((a, b) => x[a] - x[b]), law = order.map(k => 1.96 * d.law_se_m2ps2[k]), along = order.map(k => x[k]);
    traces.unshift({x: along.concat([...along].reverse()), y: law.concat(law.map(s => -s).reverse()), type: 'scatter', mode: 'lines', name: '95 % of the error of the law', fill: 'toself', fillcolor: 'rgba(31,95,168,.14)', line: {width: 0}, hoverinfo: 'skip'});
  }
  draw(parent, '', traces, {showlegend: false, xaxis: axis('twice the energy per mass gained,<br>simulated (m²/s²)', {range: [low, top], nticks: 6}),
                            yaxis: axis('sound less simulated (m²/s²)', {zeroline: true, zerolinecolor: ink, zerolinewidth: 1, exponentformat: 'power', nticks: 6})});
}

function reservoirSection(r) {
  if (!r) return;
  const own = root([r.expected_timing_m2ps2, r.expected_offset_m2ps2]);
  const parent = figure('reservoir', 'Is rotation the reservoir? What bounces take from the vertical motion, and where it is',
                        `Of each of ${number(r.n_drops)} drops: twice the energy per mass that its impacts moved out of the vertical motion, as the times of the sound and ${r.law === 'memory' ? 'the law fitted with memory' : 'the law fitted to impacts taken as independent'} give it ` +
                        `(for each impact what the vertical motion lost beyond ε), against that of sideways motion and spin as simulated, ${number(100 * r.spin_share, 3)}% of it in spin. Correlation ${r.correlation.toFixed(r.correlation > 0.999 ? 6 : 4)}; ` +
                        `rms difference ${significant(r.rms_difference_m2ps2)} m²/s² of ${significant(r.rms_simulated_m2ps2)}. Expected: ${significant(own)} of each drop’s own, from timing and from where the ball touched` +
                        (known(r.expected_law_m2ps2) ? `, and ${significant(r.expected_law_m2ps2)} from the standard error of the law, the same shift for all drops (band: 95%).` : '.') +
                        ' Bars: the drop’s own standard error.');
  parent.classList.add('pair');
  drawReservoir(parent, r);
}
