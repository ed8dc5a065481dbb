// SPDX-License-Identifier: GPL-3.0-or-later
// A sweep: what came out of the loop at each combination of settings.

/// One panel: a number against the last list, a line for each combination of the others.
function drawSwept(parent, sweep, title, key, extra) {
  const options = Object.keys(sweep.lists), along = options.at(-1), numeric = sweep.lists[along].every(v => Number.isFinite(Number(v)));
  const groups = new Map();
  for (const point of sweep.points) {
    const name = options.slice(0, -1).map(o => `${o} ${point.settings[o]}`).join(', ');
    if (!groups.has(name)) groups.set(name, []);
    groups.get(name).push(point);
  }
  const traces = [...groups].map(([name, points], k) => ({
    x: points.map(p => numeric ? Number(p.settings[along]) : p.settings[along]), y: points.map(p => p.values[key]), name: name || title, type: 'scatter', mode: 'lines+markers', bars: '',
    error_y: {type: 'data', array: points.map(p => p.values['se_' + key] ?? 0), thickness: 1.2, width: 3}, line: {color: windowColours[(2 * k + 1) % windowColours.length], width: 1.6}, marker: {size: 7}}));
  draw(parent, 'small', traces, {showlegend: groups.size > 1, margin: {l: 64, r: 10, t: 16, b: groups.size > 1 ? 90 : 46},
                                 legend: {orientation: 'h', y: -0.22, yanchor: 'top', x: 0, font: {size: 10}},
                                 xaxis: axis(optionWords(along), numeric ? {} : {type: 'category'}), yaxis: axis(title, extra)});
}

function sweepSection(sweep) {
  add('h2', {}, 'What came out at each point');
  const options = Object.keys(sweep.lists);
  const scroll = scrollPlace('What came out at each point');
  page.append(scroll);
  const cell = (v, key, digits = 4) => known(v[key]) ? number(v[key], digits) : '–';
  const withError = (v, key) => measured(v[key], v['se_' + key]);
  const speeds = Object.keys(sweep.points[0].values).filter(k => /^eps_.*_sound$/.test(k));
  scroll.append(element('table', {class: 'words'},
      element('thead', {}, element('tr', {}, [...options.map(o => o.replace(/-/g, ' ')), 'what fails', 'recall', 'precision', 'rms µs', ...speeds.map(k => k.replace(/^eps_(.*)_sound$/, 'ε($1) − truth, 10⁻⁶')),
          'A2', 'rising .6, simulation', 'rising .6, sound', 'falling .6, simulation', 'falling .6, sound'].map(headCell))),
      element('tbody', {}, sweep.points.map(p => {
        const v = p.values;
        const shift = k => known(v[k]) ? measured(1e6 * (v[k] - v[k.replace('_sound', '_truth')]), 1e6 * v['se_' + k]) : '–';
        return element('tr', {}, options.map(o => element('td', {}, p.settings[o])), element('td', {class: p.trouble ? 'text no' : 'text yes'}, p.trouble || 'nothing'), [cell(v, 'recall_1ms'), cell(v, 'precision_1ms'), known(v.within_drops_s) ? number(1e6 * v.within_drops_s, 3) : '–',
          ...speeds.map(shift), withError(v, 'A2'), withError(v, 'slope_rising_0.6_simulation'), withError(v, 'slope_rising_0.6_sound'), withError(v, 'slope_falling_0.6_simulation'), withError(v, 'slope_falling_0.6_sound')]
            .map(t => element('td', {}, t)));
      }))));
  add('p', {class: 'caption'}, '“What fails” compares the times detected with the true times of the same drops: 99% of the impacts found and 99% of the found ones true, ε(v) moved by less than its standard error, slopes by less than a tenth.');
  const parent = figure('sweep', 'The same as pictures', `Against ${options.at(-1).replace(/-/g, ' ')}; a line for each combination of the other lists. Bars: standard errors.`);
  parent.classList.add('grid', 'wide');
  drawSwept(parent, sweep, 'share of impacts found', 'recall_1ms', {});
  drawSwept(parent, sweep, 'rms error of the times within drops (s)', 'within_drops_s', {type: 'log', exponentformat: 'power'});
  drawSwept(parent, sweep, 'rising slope at 0.6 m/s, sound', 'slope_rising_0.6_sound', {});
  drawSwept(parent, sweep, 'falling slope at 0.6 m/s, sound', 'slope_falling_0.6_sound', {});
}
