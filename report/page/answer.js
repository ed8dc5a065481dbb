// SPDX-License-Identifier: GPL-3.0-or-later
// The first screen: the answer in a few sentences, the picture of eps against speed, the sound; then the questions.

/// Recordings by file name where that tells them apart: "a.wav" for "/home/me/a.wav".
const fileName = path => String(path).replace(/^.*[/\\]/, '') || String(path);
const recordingPaths = [...new Set([...((summary && summary.recordings) || []), ...((fit && fit.recordings) || []), wave || {}].map(r => r.recording).filter(Boolean))];
const namesDiffer = new Set(recordingPaths.map(fileName)).size === recordingPaths.length;
const shownName = path => namesDiffer ? fileName(path) : path;
const withoutPaths = text => namesDiffer ? [...recordingPaths].sort((a, b) => b.length - a.length).reduce((t, path) => t.replaceAll(path, fileName(path)), text) : text;

const lengthText = h => !known(h) ? '–' : h < 0.01 ? `${number(1e3 * h, 2)} mm` : h < 1 ? `${number(1e2 * h, 2)} cm` : `${number(h, 2)} m`;
const heightText = seen => seen.drop_heights_m ? `${lengthText(seen.drop_heights_m[0])} to ${lengthText(seen.drop_heights_m[1])}` : lengthText(seen.drop_height_m) + (seen.drop_height_ci95_m ? ` (${lengthText(seen.drop_height_ci95_m[0])} to ${lengthText(seen.drop_height_ci95_m[1])})` : '');
const timeText = t => known(t) ? `${number(t, 2)} s` : '–';

/// Where the errors of the points come from: of heights and speeds there are no impacts and times.
const sourceOfErrors = answer => answer?.seen?.n_impacts === null ? 'measuring' : 'timing';

/// What the signs of the answer mean, each where it is used.
function explanations(answer) {
  const at = answer.at || (answer.recordings || []).map(r => r.at).find(Boolean), parts = [];
  if (at && known(at.eps)) parts.push('ε (epsilon), the coefficient of restitution: speed just after a bounce over speed just before it; 1 would be a ball that loses nothing.');
  if (at && known(at.se)) parts.push('± is the standard error: how far off the value typically is.');
  if (at && at.ci95) parts.push('95 %: of 20 such ranges 19 hold the true value.');
  if (answer.seen && known(answer.seen.drop_height_m)) parts.push('The height follows from the flight after the first impact, ε there and the resistance of the air.');
  return parts.join(' ');
}

/// A table with a row for each of several recordings.
function recordingRows(parent, answer) {
  const rows = (answer.recordings || []).slice(0, 50);
  if (!rows.length) return;
  const lengthOf = name => (((summary && summary.recordings) || []).find(r => r.recording === name) || {}).duration_s;
  const percent = x => known(x) ? `${(100 * x).toFixed(1)} %` : '–';
  table(nounOfRows === 'plate' ? 'Plate by plate' : 'Recording by recording', [nounOfRows, 'ε', '95 %', 'speed', 'energy lost', 'impacts', 'height', 'bouncing', 'length'],
        rows.map(r => [shownName(r.recording) || '(no name)', r.at ? measured(r.at.eps, r.at.se) : r.missing || '–', interval(r.at && r.at.ci95), r.at ? speed(r.at.v_mps) : '–', percent(r.at && r.at.energy_lost),
                       number(r.seen.n_impacts), heightText(r.seen), timeText(r.seen.duration_s), timeText(lengthOf(r.recording))]),
        `Each ${nounOfRows} alone: ε with its standard error and 95 % range at that speed, energy lost in a bounce, height of the drop with its 95 % range, time from first to last impact, length of the recording. Heights only where the recording begins early enough for the first impact to be known as the first.` +
        (answer.recordings.length > rows.length ? ` The first ${rows.length} of ${answer.recordings.length}; all are in fit.json.` : ''), parent);
}

function firstScreen() {
  const answer = fit && fit.answer;
  if (!fit) return;
  const section = add('section', {class: 'first', id: 'answer', 'aria-label': 'The answer'});
  const words = element('div', {class: 'says'});
  section.append(words);
  if (answer) {
    const [lead, ...rest] = answer.sentences;
    words.append(element('p', {class: 'lead'}, lead), ...[...rest, ...(answer.doubt ? [withoutPaths(answer.doubt)] : [])].map(s => element('p', {}, s)));
    const taken = (summary && summary.taken) || fit.taken || [];
    if (taken.length) words.append(element('p', {class: 'caption'}, `Taken: ${taken.map(t => `${t.what} ${t.value}`).join(', ')}.`.replace(/\^2/g, '²').replace(/\^3/g, '³')));
    if (explanations(answer)) words.append(element('p', {class: 'caption'}, explanations(answer)));
  }
  const hasCurve = answerCurve(fit).length;
  if (few || hasCurve || (fit.density && fit.density.counts.length)) {
    const places = figure('law', 'ε against impact speed', lawCaption(), section);
    drawLaw(places);
  }
  if ((fit.causes || []).length) add('div', {}, causesBox(fit.causes));
  if (answer) recordingRows(page, answer);
  if (wave && wave.envelope) drawSound();
}

/// Why eps is not the same at every bounce: three sentences and how large each cause is, drawn to one scale.
function causesBox(causes) {
  const sized = causes.filter(c => c.size > 0), most = Math.max(...sized.map(c => c.size));
  const bars = sized.map(c => {
    const bar = element('i', c.is_seen ? {class: 'seen'} : {});
    bar.style.width = `${100 * c.size / most}%`;
    return element('div', {}, element('span', {}, c.name), element('span', {class: 'bar'}, bar), element('span', {}, number(c.size, 2) + (c.is_seen ? '' : ', not seen')));
  });
  return element('section', {class: 'causes', id: 'causes', 'aria-labelledby': 'causes-title'}, element('h2', {id: 'causes-title'}, 'Why is it not the same at every bounce?'),
                 causes.map(c => element('p', {}, c.sentence)), bars.length ? [element('div', {class: 'bars'}, bars), element('p', {class: 'caption'}, 'How much each changes ε here.')] : []);
}

function pointsCaption() {
  const withError = `with the error that ${sourceOfErrors(fit.answer)} alone gives them`;
  if (samples.measured === 'speeds') return `Points: bounces, ${withError}.`;
  const [flights, taken] = samples.measured === 'heights' ? ['heights', 'the air'] : ['intervals', 'air and contact'];
  return `Points: bounces, without what ${taken} did to their ${flights}, ${withError}.`;
}

function lawCaption() {
  return (few ? pointsCaption() : 'Colour: number of bounces in each cell, on a logarithmic scale.') +
      (answerCurve(fit).length ? ' Line and band: ε(v), the root mean square of the bounces at each speed, with its 95 % range.' : '') +
      (summary && summary.truth_curve ? ' Dashes: the law that went in, at the point of contact; the most frequent ε follows it.' : '');
}

function questions() {
  const answers = (fit && fit.answers) || [];
  if (!answers.length) return;
  add('h2', {id: 'questions'}, 'Questions and answers');
  add('dl', {class: 'answers'}, answers.map(a => [element('dt', {}, a.question), element('dd', {}, withoutPaths(a.answer).replace(/\+-/g, '±'))]));
}

function notes() {
  const warnings = notesOf('warning');
  if (!warnings.length) return;
  add('h2', {id: 'notes'}, 'What to know before using it');
  add('div', {class: 'warnings'}, element('ul', {}, warnings.map(w => element('li', {}, withoutPaths(w)))));
}

function details() {
  const list = notesOf('detail');
  if (!list.length) return;
  add('h2', {id: 'details'}, 'Details');
  add('ul', {}, list.map(w => element('li', {}, withoutPaths(w))));
}
