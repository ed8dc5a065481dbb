// SPDX-License-Identifier: GPL-3.0-or-later
// The parts of the page that need no browser.
import assert from 'node:assert/strict';
import {test} from 'node:test';
import {readFileSync} from 'node:fs';
import {containerRate, isOurs} from '../page/container_rate.js';
import {added, moved, removed, Marks} from '../page/marks.js';
import {columnsFrom, marksFrom} from '../page/tables.js';
import {envelopeOf, interleave, kBlock} from '../page/sound.js';
import {compare} from '../page/simulate.js';
import {roundTicks} from '../page/picture.js';
import {plain} from '../page/trouble.js';
import {Live} from '../page/live.js';
import {clean, fromClean, made} from './harness.js';

test('the header of each container gives the sampling rate and the coding that the sound was written with', t => {
  const formats = [['a.m4a', 44100, 'AAC', '-ar', '44100', '-c:a', 'aac'], ['b.m4a', 48000, 'AAC', '-c:a', 'aac'], ['c.mp3', 32000, 'MP3', '-ar', '32000'], ['d.mp3', 22050, 'MP3', '-ar', '22050'],
                   ['e.ogg', 44100, 'Vorbis', '-ar', '44100', '-c:a', 'libvorbis'], ['f.ogg', 48000, 'Opus', '-c:a', 'libopus'], ['g.webm', 48000, 'Opus', '-c:a', 'libopus'], ['h.webm', 44100, 'Vorbis', '-ar', '44100', '-c:a', 'libvorbis'],
                   ['i.mov', 48000, '', '-c:a', 'pcm_s16le'], ['j.aac', 44100, 'AAC', '-ar', '44100', '-c:a', 'aac'], ['k.mkv', 32000, 'AAC', '-ar', '32000', '-c:a', 'aac'], ['l.m4a', 48000, '', '-c:a', 'alac'],
                   ['n.mkv', 48000, '', '-c:a', 'flac'], ['o.mkv', 48000, '', '-c:a', 'pcm_s24le'], ['p.mp4', 48000, '', '-c:a', 'flac', '-strict', '-2'], ['q.mp2', 48000, 'MP2', '-c:a', 'mp2'],
                   ['r.mkv', 48000, 'MP3', '-c:a', 'libmp3lame'], ['s.mp4', 48000, 'Opus', '-c:a', 'libopus']];
  let n = 0;
  for (const [name, rate, lossy, ...options] of formats) {
    const file = fromClean(name, '-t', '1', ...options);
    if (!file) continue;
    ++n;
    const bytes = readFileSync(file), header = containerRate(bytes);
    assert.equal(header.rate_hz, rate, name);
    assert.equal(header.hasSound, true, name);
    assert.equal(header.lossy, lossy, name);
    assert.equal(isOurs(bytes), false, name);
    for (const length of [0, 1, 7, 30, 60, 300])  // cut off anywhere: no exception
      assert.ok('rate_hz' in containerRate(bytes.subarray(0, length)), `${name}, ${length} bytes`);
  }
  if (!n) t.skip('no ffmpeg to make the files with');
});

test('a video without sound is known by its header', t => {
  const files = ['a.mp4', 'b.webm'].map(name => made(name, '-f', 'lavfi', '-i', 'testsrc=duration=1:size=64x64:rate=5')).filter(Boolean);
  if (!files.length) return t.skip('no ffmpeg to make the files with');
  for (const file of files) assert.equal(containerRate(readFileSync(file)).hasSound, false, file);
});

test('FLAC and WAV are left to our own reader', () => {
  assert.ok(isOurs(readFileSync(clean)));
  assert.ok(isOurs(new TextEncoder().encode('RIFF....WAVE')));
  assert.ok(!isOurs(new Uint8Array()));
});

const columns = {drop: Float64Array.of(0, 0, 0, 1), impact: Float64Array.of(0, 1, 3, 0), t_s: Float64Array.of(0.12656382139774158, 0.5, 1.1, 3),
  sigma_t_s: Float64Array.of(1e-6, 2e-6, 2e-6, 2e-6), amplitude: Float64Array.of(0.5, 0.4, 0.3, 0.3), snr_db: Float64Array.of(40, 38, 36, 36),
  probability: Float64Array.of(0.99, NaN, 1, 1), flags: ['', 'doubtful|clipped', '', '']};

test('columns of onsets that nobody touched come back as they were', () => {
  assert.deepEqual(columnsFrom(marksFrom(columns)), columns);
  assert.equal(marksFrom(columns)[1].probability, '');
});

test('a mark that was moved keeps its number and loses its error and its flags', () => {
  const list = moved(marksFrom(columns), 1, 0.51);
  assert.equal(list[1].t_s, 0.51);
  assert.equal(list[1].impact, 1);
  assert.equal(list[1].flags, 'by_hand');
  assert.ok(Number.isNaN(columnsFrom(list).sigma_t_s[1]) && Number.isNaN(columnsFrom(list).probability[1]));
});

const numbers = list => list.map(m => `${m.drop}.${m.impact}`).join(' ');
test('a mark added in a gap of a missing impact takes its number, elsewhere those after it move up', () => {
  const list = marksFrom(columns);
  assert.equal(numbers(added(list, 0.8)), '0.0 0.1 0.2 0.3 1.0');
  assert.equal(numbers(added(list, 0.3)), '0.0 0.1 0.2 0.4 1.0');
  assert.equal(numbers(added(list, 0.05)), '0.0 0.1 0.2 0.4 1.0');
  assert.equal(numbers(added(list, 1.4)), '0.0 0.1 0.3 0.4 1.0');
  assert.equal(numbers(added(list, 2.9)), '0.0 0.1 0.3 1.0 1.1');
  assert.equal(numbers(added([], 2.9)), '0.0');
});

test('a mark that is deleted leaves no gap, and what was done is undone', () => {
  assert.equal(numbers(removed(marksFrom(columns), 1)), '0.0 0.2 1.0');
  assert.equal(numbers(removed(marksFrom(columns), 0)), '0.0 0.2 1.0');
  const marks = new Marks(marksFrom(columns));
  marks.step(1);
  marks.remove();
  marks.add(0.7);
  marks.move(0.71);
  for (let k = 0; k < 5; ++k) marks.undo();
  assert.deepEqual(columnsFrom(marks.list), columns);
});

test('the envelope holds every extreme and channels are interleaved sample by sample', () => {
  const mono = Float32Array.from({length: 3 * kBlock + 17}, (_, k) => Math.sin(0.1 * k * k)), {lo, hi} = envelopeOf(mono);
  assert.equal(lo.length, 4);
  assert.equal(Math.max(...hi), Math.max(...mono));
  assert.equal(Math.min(...lo), Math.min(...mono));
  assert.deepEqual([...interleave([Float32Array.of(1, 2), Float32Array.of(3, 4)])], [1, 3, 2, 4]);
});

test('found beside the truth: missed and invented impacts are counted, the common shift is no error', () => {
  const times = {t_s: [0, 1, 1.9, 2.7], travel_time_s: [1e-3, 1e-3, 1e-3, 1e-3], impact: [0, 1, 2, 3], drop: [0, 0, 0, 0]};
  const marks = [0.101, 1.101, 1.5, 2.801].map(t_s => ({t_s, flags: ''}));
  const found = compare(times, marks);
  assert.equal(found.n_missed, 1);
  assert.equal(found.n_invented, 1);
  assert.ok(found.rms_s < 1e-12, `${found.rms_s}`);  // 0.1 s each, up to rounding
});

test('what is for the command line is left out', () => {
  assert.equal(plain('name the ball (--ball).'), 'name the ball.');
  assert.equal(plain('use the value of each (--pool makes one value of all); g in m/s^2'), 'use the value of each; g in m/s²');
  assert.equal(plain('which columns are the speeds (--columns v=COLUMN; of t=Time (s) too)?'), 'which columns are the speeds?');
  assert.equal(plain("a.csv: times or intervals?; say --as times (times in s) or --as intervals --columns 't=Time (s)' (intervals in s)"), 'a.csv: times or intervals?');
  assert.equal(plain("--drop-height: '1e5' must be a finite decimal number from 0 to 1000"), "Drop height: '1e5' must be a finite decimal number from 0 to 1000");
  assert.equal(plain('--unit s: heights are in m, cm, mm, in or ft'), 'Unit s: heights are in m, cm, mm, in or ft');
  assert.equal(plain("column 'v (m/s)' is another quantity (bouncelab fit takes speeds)"), "column 'v (m/s)' is another quantity");
});

test('axes have round numbers', () => {
  assert.deepEqual(roundTicks(0, 1.4, 4).map(t => t.text), ['0.0', '0.5', '1.0']);
  assert.deepEqual(roundTicks(-1, 1, 2).map(t => t.text), ['−1', '0', '1']);
  assert.deepEqual(roundTicks(0.97, 0.986, 3).map(t => t.text), ['0.97', '0.98']);
  assert.deepEqual(roundTicks(3.55, 4.45, 3).map(t => t.text), ['3.6', '3.8', '4.0', '4.2', '4.4']);  // one alone is no scale
});

/// A detector that knows the truth, but only of impacts that begin 20 ms before the end of what it is given.
class Fixed {
  /// @param n_known  of so few impacts it doubts that they are a ball's
  constructor(times, rate, n_known = 3) { Object.assign(this, {times, rate, n_known}); }
  detect(samples) {
    const begin = samples[0] * 1e3, end = begin + samples.length / this.rate;  // the sound carries its own clock
    const seen = this.times.filter(t => t >= begin && t < end - 0.02);
    return {summary: JSON.stringify({recordings: [{drops: [{doubtful: seen.length < this.n_known}]}]}),
            onsets: {t_s: seen.map(t => t - begin), drop: seen.map(() => 0), impact: seen.map((_, k) => k)}};
  }
}
test('live: a window that moves on keeps earlier bounces and their numbers, and the ball is at rest four intervals after the last', async () => {
  const rate = 1000, eps = 0.9, times = [0.5];
  for (let interval = 0.6; times.length < 12; interval *= eps) times.push(times.at(-1) + interval);
  const reports = [], live = new Live(new Fixed(times, rate), rate, 9.81, message => reports.push(message));
  for (let n = 0; !reports.at(-1)?.rest && n < 20 * rate; n += 100) {
    live.take(Float32Array.from({length: 100}, (_, k) => (n + k) / rate / 1e3));
    live.cost = 1;  // a slow machine: the shortest window
    await new Promise(resolve => setTimeout(resolve, 1));
  }
  const last = reports.at(-1);
  assert.ok(last.rest);
  assert.equal(last.n_onsets, times.length);
  assert.equal(last.points.eps.length, times.length - 2);
  for (const e of last.points.eps) assert.ok(Math.abs(e - eps) < 1e-3, `${e}`);  // the clock in 32-bit floats has 1 µs or so
  const wait = last.heard_s - times.at(-1), interval = times.at(-1) - times.at(-2);
  assert.ok(wait > Math.max(1, 4 * interval) && wait < Math.max(1, 4 * interval) + 0.3, `${wait}`);  // chunks of 0.1 s
});

test('live: a drop that is doubted is provisional, of one detection alone, and no bounce until it is known', async () => {
  const rate = 1000, times = [0.5, 1, 1.45, 1.855, 2.22], reports = [], live = new Live(new Fixed(times, rate, 5), rate, 9.81, message => reports.push(message));
  for (let n = 0; n < 2.5 * rate; n += 100) {
    live.take(Float32Array.from({length: 100}, (_, k) => (n + k) / rate / 1e3));
    await new Promise(resolve => setTimeout(resolve, 1));
  }
  for (const {heard_s, n_onsets, marked, provisional} of reports) {
    const seen = times.filter(t => t < heard_s - 0.02 - 1e-6).length, known = seen >= 5;
    assert.equal(provisional.n, known ? 0 : seen, `${heard_s}`);
    assert.equal(provisional.points.eps.length, known ? 0 : Math.max(0, seen - 2), `${heard_s}`);
    assert.equal(n_onsets, known ? seen : 0, `${heard_s}`);
    assert.ok(known || marked.length === 0, `${heard_s}`);
  }
  assert.equal(reports.at(-1).n_onsets, times.length);
  assert.ok(reports.some(r => r.provisional.points.eps.length));
});
