// SPDX-License-Identifier: GPL-3.0-or-later
// The first screen: the answer in a few sentences, the picture of eps against speed, the sound; then the questions.

/// Recordings by the shortest end of their path that no other has: "a.wav" for "/home/me/a.wav".
const recordingPaths = [...new Set([...((summary && summary.recordings) || []), ...((fit && fit.recordings) || []), wave || {}].map(r => r.recording).filter(Boolean))];
const endsOf = path => path.split(/[/\\]/).map((_, k, parts) => parts.slice(parts.length - 1 - k).join('/')).filter(Boolean);
const pathsWith = new Map();
for (const end of recordingPaths.flatMap(endsOf)) pathsWith.set(end, (pathsWith.get(end) || 0) + 1);
const shownName = path => endsOf(String(path)).find(end => !(pathsWith.get(end) > 1)) || path;
const withoutPaths = text => [...recordingPaths].sort((a, b) => b.length - a.length).reduce((t, path) => t.replaceAll(path, shownName(path)), text);

const lengthText = h => !known(h) ? '–' : h < 0.01 ? `${number(1e3 * h, 2)} mm` : h < 1 ? `${number(1e2 * h, 2)} cm` : `${number(h, 2)} m`;
const heightText = seen => seen.drop_heights_m ? `${lengthText(seen.drop_heights_m[0])} to ${lengthText(seen.drop_heights_m[1])}` : lengthText(seen.drop_height_m) + (seen.drop_height_ci95_m ? ` (${lengthText(seen.drop_height_ci95_m[0])} to ${lengthText(seen.drop_height_ci95_m[1])})` : '');
const timeText = t => known(t) ? `${number(t, 2)} s` : '–';

/// Where the errors of the points come from: of heights and speeds there are no impacts and times.
const sourceOfErrors = answer => answer?.seen?.n_impacts === null ? 'measuring' : 'timing';

/// The answer's sentences, the first of them short: what stands behind its semicolon is one of its own.
function sentencesOf(answer) {
  const [first, ...others] = answer.sentences, [head, ...tail] = first.split('; ');
  return tail.length ? [`${head}.`, tail.join('; ').replace(/^./, c => c.toUpperCase()), ...others] : answer.sentences;
}

/// What the signs of the answer mean, each where it is used.
function explanations(answer) {
  const at = answer.at || (answer.recordings || []).map(r => r.at).find(Boolean), parts = [];
  if (at && known(at.eps)) parts.push('ε (epsilon), the coefficient of restitution: speed just after a bounce over speed just before it; 1 would be a ball that loses nothing.');
  if (at && known(at.se)) parts.push('± is the standard error: how far off the value typically is.');
  if (at && at.ci95) parts.push('95 %: of 20 such ranges 19 hold the true value.');
  if (answer.sentences.some(s => /\bp [=<]/.test(s))) parts.push('p: how often chance alone would make so large a difference.');
  if (answer.seen && known(answer.seen.drop_height_m)) parts.push('The height follows from the flight after the first impact, ε there and the resistance of the air.');
  return parts.join(' ');
}

/// What is known of each of several recordings, those that could not be read or hold no ball among them.
function rowsOfRecordings(answer) {
  const heard = (summary && summary.recordings) || [], texts = ((summary && summary.notes) || []).map(note => note.text);
  const lengths = new Map(heard.map(r => [r.recording, r.duration_s]));
  const rows = answer.recordings.map(r => ({name: r.recording, ...r.at, n_drops: r.seen.n_drops, n_impacts: r.seen.n_impacts, height_m: r.seen.drop_height_m, height_ci95_m: r.seen.drop_height_ci95_m, height: heightText({...r.seen, drop_height_ci95_m: null}),
                                              bouncing_s: r.seen.duration_s, length_s: lengths.get(r.recording), remark: r.at ? '' : r.missing}));
  const without = heard.filter(r => r.status !== 'ok' && !answer.recordings.some(a => a.recording === r.recording))
      .map(r => ({name: r.recording, length_s: r.duration_s || null, remark: (texts.find(text => text.startsWith(`${r.recording}: `)) || ': no bouncing ball was found').replace(/^.*?: /, '')}));
  return [...rows, ...without];
}

const kColumnsOfRecordings = {recording: r => shownName(r.name), eps: r => r.eps, standard_error: r => r.se, low95: r => r.ci95 && r.ci95[0], high95: r => r.ci95 && r.ci95[1], v_mps: r => r.v_mps, energy_lost: r => r.energy_lost, n_drops: r => r.n_drops, n_impacts: r => r.n_impacts,
  drop_height_m: r => r.height_m, drop_height_low95_m: r => r.height_ci95_m && r.height_ci95_m[0], drop_height_high95_m: r => r.height_ci95_m && r.height_ci95_m[1], bouncing_s: r => r.bouncing_s, length_s: r => r.length_s, remark: r => r.remark};

const kMostRows = 50;
/// A row for each of several recordings; below, why some have no ε. All of it is in its CSV.
function recordingRows(parent, answer) {
  if (!(answer.recordings || []).length) return;
  const all = rowsOfRecordings(answer), found = all.filter(r => known(r.eps)), rows = found.slice(0, kMostRows), without = all.filter(r => !known(r.eps)), speeds = [...new Set(found.map(r => r.v_mps))];
  const percent = x => known(x) ? `${(100 * x).toFixed(1)} %` : '–';
  table(nounOfRows === 'plate' ? 'Plate by plate' : 'Recording by recording', [nounOfRows, 'ε ± standard error', '95 %', 'speed', 'energy lost', 'impacts', 'height'],
        rows.map(r => [shownName(r.name) || '(no name)', known(r.eps) ? measured(r.eps, r.se) : '–', interval(r.ci95), speeds.length > 1 && known(r.v_mps) ? speed(r.v_mps) : '–', percent(r.energy_lost),
                       number(r.n_impacts), r.height || '–']),
        `Each ${nounOfRows} alone: ε ${speeds.length === 1 ? `at ${speed(speeds[0])} ` : ''}with its 95 % range, energy lost in a bounce, height of the drop where its first impact was recorded.` +
        (found.length > rows.length ? ` The first ${rows.length} of ${found.length}.` : ''), parent);
  table('', [nounOfRows, 'why there is no ε'], without.slice(0, kMostRows).map(r => [shownName(r.name) || '(no name)', element('span', {class: 'words'}, withoutPaths(r.remark))]),
        without.length > kMostRows ? `The first ${kMostRows} of ${without.length}.` : '', parent);
  const csv = element('button', {type: 'button'}, 'Save all of it as CSV');
  csv.addEventListener('click', () => saved('recordings', 'csv', 'text/csv', csvText([Object.keys(kColumnsOfRecordings), ...all.map(r => Object.values(kColumnsOfRecordings).map(of => of(r)))])));
  parent.append(element('p', {class: 'save-rows'}, csv));
}

function firstScreen() {
  const answer = fit && fit.answer;
  if (!fit) return;
  const section = add('section', {class: 'first', id: 'answer', 'aria-label': 'The answer'});
  const words = element('div', {class: 'says'});
  section.append(words);
  if (answer) {
    const [lead, ...rest] = sentencesOf(answer);
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

/// @param measured  times, heights or speeds
function pointsCaption(answer, measured) {
  const withError = `with the standard error that ${sourceOfErrors(answer)} alone gives them`;
  if (measured === 'speeds') return `Points: bounces, ${withError}.`;
  const [flights, taken] = measured === 'heights' ? ['heights', 'the air'] : ['intervals', 'air and contact'];
  return `Points: bounces, without what ${taken} did to their ${flights}, ${withError}.`;
}

function lawCaption() {
  return (few ? pointsCaption(fit.answer, samples.measured) : 'Colour: number of bounces in each cell, on a logarithmic scale.') +
      (fit.is_one_ball === false ? ` The ${fit.recordings?.length > 1 ? nounOfRows + 's' : 'drops'} differ: there is no curve of all${ownTraces().length ? ', lines are those of each' : ''}.` : '') +
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
