// SPDX-License-Identifier: GPL-3.0-or-later
// All computation of the page: the module, the sound that is open, and what was found in it. One task at a time, each
// answered by its number; a live recording is detected again and again in between.
import createModule from './bouncelab.js';
import {Live} from './live.js';
import {interleave, soundSummary, envelopeOf, channelOf} from './sound.js';
import {lists, marksFrom, columnsFrom} from './tables.js';

let module = null, sound = null, live = null, times = null;  // a file of times in place of sound

/// What the page draws; the rest stays in the module until it is saved.
/// @param withSound  give the sound too; null: there is none
function resultFor(analysis, withSound) {
  const summary = JSON.parse(analysis.summary), fit = JSON.parse(analysis.fit), channel = analysis.channel;
  const recording = summary.recordings?.[0] ?? {};
  const result = {
    summary, channel, status: recording.status,
    answer: fit?.answer ?? null,
    fitted: fit && {is_one_ball: fit.is_one_ball, curve: fit.curve && {points: fit.curve.points, errors_over_digits: fit.curve.errors_over_digits}, causes: fit.causes},
    histograms: (fit?.histograms ?? []).filter(h => h.curve?.eps?.length),
    warnings: [...new Set([...(withSound === null ? [] : sound.warnings), ...(summary.notes ?? fit?.notes ?? []).filter(note => note.severity !== 'detail').slice(0, 3).map(note => note.text)])],
    samples: lists(analysis.samples_at_plate ?? analysis.samples),  // where the curve is
    marks: marksFrom(analysis.onsets),
  };
  return withSound ? {...result, ...drawn(channelOf(sound, channel))} : result;
}

/// A channel with its envelope, given away to the page.
function drawn(mono) {
  const envelope = envelopeOf(mono);
  return {mono, envelope, transfer: [mono.buffer, envelope.lo.buffer, envelope.hi.buffer]};
}
/// What the module asks for: the sound and the options, with the coding by which its samples came.
const soundAnd = options => [sound.samples, sound.rate_hz, sound.n_channels, sound.name, JSON.stringify({...options, 'lossy-coding': sound.lossy || null})];
const nothingFound = message => ({failed: true, summary: {}, channel: 0, message, answer: null, fitted: null, histograms: [], warnings: sound.warnings, samples: {n: 0}, marks: []});

/// Out of memory, or a fault inside the module: it cannot go on, and the page starts another one.
const isFatal = error => error instanceof WebAssembly.RuntimeError || error instanceof RangeError;

/// A small experiment that nobody sees: the browser compiles code when it first runs, which would else make the first
/// recording take twice as long.
function warmUp() {
  if (sound || live) return;  // too late: it would only delay
  const made = module.simulate(JSON.stringify({drops: 1, impacts: 30, asperities: 1000, rate: 48000}));
  if (!sound && !live) module.analyze(made.samples, made.rate_hz, 1, 'warm-up', '{}');
}

const tasks = {
  async start() {
    module = await createModule();
    setTimeout(warmUp, 200);  // once the page has been drawn
    return {version: module.version(), ...JSON.parse(module.balls())};
  },
  open({name, bytes, isTable, channels, rate_hz, format, lossy}) {
    sound = times = null;
    if (isTable || (bytes && module.holdsTimes(bytes))) {
      times = {name, bytes};
      return {name, times: true};
    }
    if (bytes) {
      const read = module.readSound(bytes, name);
      sound = {name, samples: read.samples, rate_hz: read.rate_hz, n_channels: read.n_channels, format: read.format, lossy: read.lossy_coding, warnings: [...read.warnings]};
    } else {
      sound = {name, samples: interleave(channels), rate_hz, n_channels: channels.length, format, lossy, warnings: []};
    }
    return soundSummary(sound);
  },
  analyze({options}) {
    let analysis;
    try {
      analysis = module.analyze(...soundAnd(options));
    } catch (error) {
      if (isFatal(error)) throw error;
      return {...nothingFound(String(error?.message ?? error)), ...drawn(channelOf(sound, 0))};  // the sound is shown, to be marked by hand
    }
    return resultFor(analysis, true);
  },
  times({options}) {
    let analysis;
    try {
      analysis = module.analyzeTimes(times.bytes, times.name, JSON.stringify(options));
    } catch (error) {
      if (!error.question?.readings.length) throw error;
      return {question: error.question};
    }
    return {...resultFor(analysis, null), takenFor: analysis.taken_for};
  },
  refit({marks, options}) {
    return resultFor(module.analyzeOnsets(columnsFrom(marks), ...soundAnd(options)), false);
  },
  simulate({options}) {
    const made = module.simulate(JSON.stringify(options));
    sound = {name: 'simulated', samples: made.samples, rate_hz: made.rate_hz, n_channels: 1, format: 'simulated', warnings: []};
    const playable = made.samples.slice();
    return {...soundSummary(sound), samples: playable, truth: lists(made.truth), impacts: lists(made.impacts),
            law: JSON.parse(made.law), transfer: [playable.buffer]};
  },
  async save({name}) {
    const text = module.file(name);
    return {text: name === 'report.html' ? module.withPlotly(text, await (await fetch('plotly.js')).text()) : text};
  },
  scatter({options}) {
    return {theory: JSON.parse(module.scatter(JSON.stringify(options)))};
  },
  wav() {
    const bytes = module.wav(sound.samples, sound.rate_hz, sound.n_channels);
    return {bytes, transfer: [bytes.buffer]};
  },
  'live-begin'({rate_hz, gravity_mps2}) {
    live = new Live(module, rate_hz, gravity_mps2, message => self.postMessage({live: message}));
  },
  'live-more'({samples}) {
    live?.take(samples);
  },
  'live-end'({name, warnings}) {
    sound = {name, samples: live.all(), rate_hz: live.rate_hz, n_channels: 1, format: 'microphone, 32-bit float', warnings};
    live.end();
    live = null;
    return soundSummary(sound);
  },
};

self.onmessage = async ({data}) => {
  const begin = performance.now();
  try {
    const {transfer = [], ...result} = await tasks[data.task](data) ?? {};
    if (data.id !== undefined) self.postMessage({id: data.id, result, seconds: (performance.now() - begin) / 1e3}, transfer);
  } catch (error) {
    self.postMessage({id: data.id, error: String(error?.message ?? error), fatal: isFatal(error) || module === null});
  }
};
