// SPDX-License-Identifier: GPL-3.0-or-later
// Onset detectors against true times: scores, what they depend on, the recordings where each is worst.


const detectorColours = [blue, orange, green, red, ink, grey];
const isNumeric = texts => texts.length > 1 && texts.every(t => t !== '' && Number.isFinite(Number(t)));
const share = x => known(x) ? x.toFixed(3) : '–';
const micro = x => known(x) ? significant(1e6 * x) : '–';
const scoreHeads = ['found', 'F ±50 ms', 'F ±5 ms', 'F ±1 ms', 'F ±.1 ms', 'precision', 'recall', 'offset, µs', 'jitter, µs', '× bound', 'error of ε', 'pull', 'largest', 'in 95 %', 'invented an hour', '× real time'];
const scoreCells = s => [`${number(s.n_found)} of ${number(s.n_true)}`, share(s.f_50ms), share(s.f_5ms), share(s.f_1ms), share(s['f_0.1ms']), share(s.precision_5ms), share(s.recall_5ms), micro(s.offset_s), micro(s.within_drops_s),
                         significant(s.bound_ratio_within_drops), significant(s.eps_error), known(s.pull) ? s.pull.toFixed(2) : '–', significant(s.largest_pull), share(s.coverage), significant(s.invented_per_hour), known(s.times_real_time) ? number(Math.round(s.times_real_time)) : '–'];

/// One number of every detector against the values of one list, or of the first recording and of several short lists.
function drawFactors(parent, validation, options, key, words, extra, bound) {
  const alone = options.length === 1, of = d => d.factors.filter(f => options.includes(f.option)), numeric = alone && isNumeric(of(validation.detectors[0]).map(f => f.value));
  const place = f => numeric ? Number(f.value) : alone ? f.value : `${f.option.replace(/-/g, ' ')} ${f.value}`;
  const isFirst = (f, k, all) => k === 0 || all[k - 1].option !== f.option;  // the same recording in every list
  const points = d => of(d).flatMap((f, k, all) => alone || !isFirst(f, k, all) ? [{x: place(f), score: f.score}] : k === 0 ? [{x: 'none of these', score: f.score}] : [])
                          .sort((a, b) => numeric ? a.x - b.x : 0);
  const traces = validation.detectors.map((d, k) => ({x: points(d).map(p => p.x), y: points(d).map(p => p.score[key]), type: 'scatter', mode: numeric ? 'lines+markers' : 'markers', name: d.detector,
                                                      line: {color: detectorColours[k % detectorColours.length], width: 1.6}, marker: {size: 8, symbol: k, color: detectorColours[k % detectorColours.length]}}));
  if (bound) traces.push({x: points(validation.detectors[0]).map(p => p.x), y: points(validation.detectors[0]).map(p => p.score.bound_s), type: 'scatter', mode: numeric ? 'lines' : 'markers', name: 'Cramér–Rao bound',
                          line: {color: red, dash: 'dash', width: 1.6}, marker: {symbol: 'line-ew', size: 12, line: {width: 2, color: red}}});
  draw(parent, alone ? 'small' : '', traces, {showlegend: true, title: {text: alone ? '' : 'one thing different', font: {size: 13}, x: 0.5, y: 0.98}, margin: {l: 64, r: 10, t: 54, b: numeric ? 50 : 110},
                                              xaxis: axis(alone ? optionWords(options[0]) : 'what is different from the first recording', numeric ? {} : {type: 'category'}), yaxis: axis(words, extra)});
}

/// The sound of a recording, what is true (below) and what was marked (above).
function drawMarked(parent, worst) {
  const {envelope: e} = worst.wave, level = 1.08 * Math.max(...e.hi.map(Math.abs), ...e.lo.map(Math.abs), 1e-12);
  const marks = (times, y, color, name) => ({x: times, y: times.map(() => y), mode: 'markers', type: 'scatter', name, marker: {symbol: 'line-ns', size: 9, line: {width: 1.2, color}}, hovertemplate: '%{x:.6f} s<extra></extra>'});
  draw(parent, 'low', [{x: e.t_s, y: e.lo, mode: 'lines', type: 'scatter', line: {width: 0.6, color: grey}, hoverinfo: 'skip', showlegend: false},
                       {x: e.t_s, y: e.hi, mode: 'lines', type: 'scatter', line: {width: 0.6, color: grey}, fill: 'tonexty', fillcolor: 'rgba(120,132,145,.45)', name: 'sound', hoverinfo: 'skip'},
                       marks(worst.marked_s, level, red, 'marked'), marks(worst.true_s, -level, blue, 'true')],
       {title: {text: `${worst.recording}: F ±5 ms ${share(worst.f)}`, font: {size: 13}, x: 0.5, y: 0.98}, margin: {l: narrow ? 52 : 68, r: narrow ? 8 : 18, t: 54, b: 46}, xaxis: axis('time (s)'), yaxis: axis('amplitude (full scale = 1)', {range: [-1.12 * level, 1.12 * level]})});
}

function validationPage(validation) {
  const options = [...new Set(validation.detectors[0].factors.map(f => f.option))];
  table('All recordings', ['detector', ...scoreHeads], validation.detectors.map(d => [d.n_failed ? `${d.detector} (failed in ${d.n_failed})` : d.detector, ...scoreCells(d.all)]),
        `${number(validation.detectors[0].all.n_recordings)} recordings, ${number(validation.detectors[0].all.n_true)} true impacts. Counts are summed, errors are medians over recordings. F is the harmonic mean of precision and recall: within 50 ms of the time as marked, as mir_eval and MIREX count it, and closer about each recording’s offset; found, precision and recall at ±5 ms. Jitter: rms error within a drop, of pairs within 5 ms, three at least${known(validation.detectors[0].all.within_law_s) ? ', less b v^(−1/5), where in the contact an onset is marked' : ''}. Pull: error of intervals over the error stated. A detector that fails has missed the impacts of that recording.`);
  if (options.length) {
    const nValues = option => validation.detectors[0].factors.filter(f => f.option === option).length;
    const long = options.filter(option => nValues(option) > 3), short = options.filter(option => nValues(option) <= 3);
    const drawAllOf = (name, title, caption, key, words, extra, bound) => {
      const parent = figure(name, title, caption), panels = element('div', {class: 'grid wide'});
      parent.append(panels);
      for (const option of long) drawFactors(panels, validation, [option], key, words, extra, bound);
      if (short.length) drawFactors(parent, validation, short, key, words, extra, bound);
    };
    drawAllOf('found', 'What is found', 'F-measure at ±5 ms. In each recording one thing is different from the first.', 'f_5ms', 'F-measure at ±5 ms', {range: [-0.05, 1.05]}, false);
    drawAllOf('jitter', 'How exactly', 'Rms error of the times within a drop (s), beside the bound that no unbiased estimate can beat on average. Pairs further than 5 ms are not in it.', 'within_drops_s', 'rms error of times<br>within a drop (s)', {type: 'log', exponentformat: 'power', dtick: 1}, true);
  }
  for (const d of validation.detectors) {
    if (!(d.worst || []).length) continue;
    const parent = figure('worst-' + validation.detectors.indexOf(d), `Where ${d.detector} is worst`, 'The three recordings with the lowest F-measure at ±5 ms.');
    for (const worst of d.worst) drawMarked(parent, worst);
  }
  for (const d of validation.detectors) {
    table(d.detector, ['recording', 'differs in', ...scoreHeads], d.recordings.map(r => [r.recording, r.setting || '–', ...scoreCells(r.score)]));
    const failed = d.recordings.filter(r => r.failure);
    if (failed.length) add('ul', {}, failed.map(r => element('li', {}, `${r.recording}: ${r.failure}`)));
  }
}
