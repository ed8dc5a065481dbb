// SPDX-License-Identifier: GPL-3.0-or-later
// The page as a whole: three ways to a sound, one way from there to the result.
import {Engine} from './engine.js';
import {acceptFiles, readFile} from './files.js';
import {Microphone} from './microphone.js';
import {Settings} from './settings.js';
import {Survey} from './survey.js';
import {SoundSection} from './sound_section.js';
import {Trouble, checkBrowser, plain, say, sayTrouble, working} from './trouble.js';
import {drawDistributions, drawLaw, showAnswer} from './result.js';
import {showDownloads} from './downloads.js';
import {acceptNumbers} from './numbers.js';
import {hideQuestion, showQuestion} from './question.js';
import {scatterOptions, showClosedLoop, showScatter, simulateOptions, trueCurve} from './simulate.js';

const $ = id => document.getElementById(id);
let open = null;        // what is on the page: {stem, rate_hz, wav, simulated}, of times {stem, reading}; given: the fields it was computed with, isHeard: its marks are on the page
let section = null;     // the sound and its marks
let refitting = false, wanted = null;

/// The answer that is shown is not, or not any more, that of what is given now.
function outdated(is) {
  $('result').classList.toggle('stale', is);
  $('result').classList.toggle('outdated', is);
  $('outdated').hidden = !is;
}

let turn = 0;           // counts the sounds that were begun: what belongs to an earlier one is not shown any more
let works = 0;
let microphone, engine;
const survey = new Survey($('recordings'), () => settings.options(), file => takeFile(file));

/// Work on the sound that is begun, or on the one that is open. Cancel is offered after a second.
async function work(action, begins = false) {
  const mine = begins ? ++turn : turn, stays = () => { if (mine !== turn) throw null; };
  ++works;
  working(true);
  const offer = setTimeout(() => { $('cancel').hidden = false; }, 1000);
  try {
    await action(stays);
  } catch (error) {
    if (mine === turn && error !== null) {
      outdated(true);
      sayTrouble(error);
    }
  }
  clearTimeout(offer);
  if (--works) return;
  $('cancel').hidden = true;
  working(false);
}

const settings = new Settings(() => {
  if (open?.times) work(showTimes);
  else if (open?.isHeard) refit(section.marks.list);  // before, the marks are those of another sound
  survey.again();
}, () => outdated(open?.given !== settings.given()));
/// A simulated ball and plate are known.
function optionsNow() {
  const options = {...settings.options(), ...open.simulated?.known};
  open.given = settings.given();
  return options;
}

/// Yields to the browser: what comes before it is shown, and no task is long.
const breath = () => new Promise(resolve => setTimeout(resolve, 0));

async function show(result) {
  outdated(false);
  showAnswer(result);
  await breath();
  drawLaw(result, trueCurve(open.simulated?.law));
  await breath();
  drawDistributions(result);
  if (open.simulated) showClosedLoop(open.simulated, section.marks.list);
  showDownloads($('downloads'), engine, open.stem, !result.failed, result.answer?.seen.n_impacts !== null, open.wav, sayTrouble);
}

/// The answer and its picture, or where the window is too low for both, from the answer on.
const showFirst = () => document.querySelector('.first').scrollIntoView({block: 'nearest'});

async function analyze(stays) {
  $('closed-loop').hidden = $('scatter').hidden = true;
  const result = await engine.run({task: 'analyze', options: optionsNow()});
  stays();
  $('result').hidden = $('sound-section').hidden = false;
  await breath();
  if (!section) section = new SoundSection($('sound'), marks => refit(marks));
  section.load(result.mono, result.envelope, open.rate_hz, result.marks);
  open.isHeard = true;
  await breath();
  await show(result);
  const seconds = `${open.note ? open.note + ' ' : ''}${number(open.duration_s, 3)} s of sound at ${number(open.rate_hz)} Hz, ${open.format}; computed in ${number(result.seconds, 2)} s.`;
  say(open.said ? `${open.said}${seconds}` : seconds);
  showFirst();
  document.dispatchEvent(new CustomEvent('bouncelab-result', {detail: {seconds: result.seconds, n_marks: result.marks.length}}));
  if (open.given !== settings.given()) refit(section.marks.list);  // told meanwhile
}

/// A file of times has no sound to be shown.
async function showTimes(stays) {
  const result = await engine.run({task: 'times', options: {...optionsNow(), ...open.reading}});
  stays();
  if (result.question) return ask(result.question);
  settings.asksHeight(!/^(heights|speeds)/.test(result.takenFor));
  $('closed-loop').hidden = $('scatter').hidden = $('sound-section').hidden = true;
  $('result').hidden = false;
  await show(result);
  say(result.takenFor ? `Read as ${result.takenFor}.` : `${number(result.marks.length)} impact times.`);
  showFirst();
  document.dispatchEvent(new CustomEvent('bouncelab-result', {detail: {seconds: result.seconds, n_marks: result.marks.length}}));
}

/// What a table does not prove; a second question may follow the answer to the first.
function ask(question) {
  $('result').hidden = true;
  say(plain(question.text).replace(/[^?]$/, '$&.'));
  showQuestion(open.typed ? {...question, columns: []} : question, reading => {  // what is typed stands above
    $('result').hidden = true;
    open.reading = reading;
    work(showTimes);
  });
}

/// Corrected marks, or other settings: the newest are fitted, those between are skipped.
async function refit(marks) {
  wanted = marks;
  if (refitting) return;
  refitting = true;
  $('result').classList.add('stale');
  await work(async stays => {
    while (wanted) {
      const now = wanted;
      wanted = null;
      const result = await engine.run({task: 'refit', marks: now, options: optionsNow()});
      stays();
      if (!wanted) await show(result);
    }
  });
  wanted = null;
  refitting = false;
  document.dispatchEvent(new CustomEvent('bouncelab-refit'));
}

async function openSound(summary, more, stays) {
  stays();
  if (summary.times) {
    open = {stem: summary.name.replace(/\.[^.]*$/, '') || 'times', times: true, reading: more.reading, typed: Boolean(more.reading)};
    return showTimes(stays);
  }
  const {name, rate_hz, duration_s, format, peak} = summary;
  open = {stem: name.replace(/\.[^.]*$/, '') || 'sound', rate_hz, duration_s, format, ...more};
  if (peak === 0) {
    clear();
    throw new Trouble(`${name} is silent: all of its samples are zero.`);
  }
  say('Finding the bounces …');
  await analyze(stays);
}

/// What was found in the sound before is no answer to the next one.
function clear() {
  $('result').hidden = true;
  hideQuestion();
  settings.asksHeight(true);
  open = null;
}

/// @param reading  options that tell how a table is read; absent: is it one?
function takeFile(file, reading) {
  return work(async stays => {
    clear();
    say(`Reading ${file.name} …`);
    const {bytes, channels, note, refused, ...rest} = await readFile(file, Boolean(reading));
    await engine.ready;
    stays();
    const transfer = bytes ? [bytes.buffer] : channels.map(c => c.buffer);
    const opened = engine.run({task: 'open', name: file.name, bytes, channels, ...rest}, transfer);
    await openSound(await (refused ? opened.catch(() => { throw new Trouble(refused); }) : opened), {note, reading}, stays);
  }, true);
}

/// Several files: the first at once, all in a table, others by their names there.
function takeFiles(files, reading) {
  if (!files.length) return;
  survey.begin(files.length > 1 ? files : []);
  microphone.close();
  panel(null);
  takeFile(files[0], reading);
}

function panel(name) {
  for (const way of ['microphone', 'simulate']) {
    const shown = way === name && $(way).hidden;
    $(way).hidden = !shown;
    $(`way-${way}`).setAttribute('aria-expanded', String(shown));
  }
  $('settings').hidden = !$('simulate').hidden;  // ball and height of a simulated drop are known
}

/// The sound that was made here can be saved too.
const wav = () => engine.run({task: 'wav'});

async function simulate() {
  await work(async stays => {
    clear();
    say('Dropping the ball …');
    const options = simulateOptions(settings), simulated = await engine.run({task: 'simulate', options});
    simulated.known = {ball: options.ball, plate: options.plate, gravity: 9.81};
    survey.begin([]);
    await openSound(simulated, {simulated, wav}, stays);
    section.playAll();
    const {theory} = await engine.run({task: 'scatter', options: scatterOptions(options)});
    stays();
    showScatter(theory);
  }, true);
}

async function recorded(why, warnings) {
  await work(async stays => {
    const name = `recording-${new Date().toISOString().slice(0, 19).replace(/:/g, '')}.wav`;
    const summary = await engine.run({task: 'live-end', name, warnings});
    survey.begin([]);
    await openSound(summary, {said: why, wav}, stays);
  }, true);
}

function keepOffline() {
  if ('serviceWorker' in navigator && location.protocol !== 'file:') navigator.serviceWorker.register('service_worker.js').catch(() => {});  // without it the page works as long as there is a connection
}

function start() {
  checkBrowser();
  engine = new Engine();
  engine.onTrouble = sayTrouble;
  engine.onRestart = clear;  // the worker that is new has no sound
  engine.ready.then(started => {
    settings.fill(started);
    $('version').textContent = `bouncelab ${started.version}`;
    keepOffline();
  }).catch(sayTrouble);
  microphone = new Microphone(engine, settings, () => { survey.begin([]); clear(); }, recorded);
  microphone.onTrouble = sayTrouble;
  acceptFiles($('way-file'), $('file'), takeFiles);
  acceptNumbers(takeFiles, () => outdated(Boolean(open?.typed)), error => {
    outdated(true);
    sayTrouble(error);
  });
  $('simulate').addEventListener('input', () => outdated(Boolean(open?.simulated)));
  $('way-microphone').addEventListener('click', () => { panel('microphone'); if ($('microphone').hidden) microphone.close(); });
  $('way-simulate').addEventListener('click', () => { panel('simulate'); microphone.close(); });
  $('simulate-run').addEventListener('click', simulate);
  $('cancel').addEventListener('click', () => { engine.restart('Cancelled.'); });
}

try {
  start();
} catch (error) {
  sayTrouble(error);
  for (const id of ['way-file', 'way-microphone', 'way-simulate', 'numbers-run']) $(id).disabled = true;
}
