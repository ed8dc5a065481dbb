// SPDX-License-Identifier: GPL-3.0-or-later
// The module by itself, in node.
import assert from 'node:assert/strict';
import {before, describe, test} from 'node:test';
import {existsSync, readFileSync} from 'node:fs';
import {join} from 'node:path';
import {pathToFileURL} from 'node:url';
import {Live} from '../page/live.js';
import {plain} from '../page/trouble.js';
import {clean, site, truth} from './harness.js';

const missing = existsSync(join(site, 'bouncelab.wasm')) ? false : `no ${site}; tools/web/build makes it`;

describe('the module', {skip: missing}, () => {
  let module;
  before(async () => {
    const {default: create} = await import(pathToFileURL(join(site, 'bouncelab.js')));
    module = await create({wasmBinary: readFileSync(join(site, 'bouncelab.wasm'))});
  });

  test('live: every bounce is marked by the second detection that heard a tenth of a second beyond it', async t => {
    const kStep_s = 0.2, kBeyond_s = 0.1, kEnd_s = 9;
    const {samples, rate_hz} = module.readSound(readFileSync(clean), 'clean.flac'), step = kStep_s * rate_hz;
    const reports = [], live = new Live(module, rate_hz, 9.81, report => reports.push(report));
    for (let n = 0; n < kEnd_s * rate_hz; n += step) {
      live.take(samples.slice(n, n + step));
      live.cost = 1;  // the shortest window, whatever the machine
      await new Promise(resolve => setTimeout(resolve, 1));
    }
    const first = reports.findIndex(r => r.marked.length), known = reports[first].marked.length;
    // that a rhythm is a bouncing ball and no other is held for ten times as probable from the seventh bounce on: those
    // before are marked together
    assert.ok(known >= 3 && known <= 8, `${known}`);
    // the one before it is provisional: of the sixth bounce the odds are 5, of the seventh 25
    const perhaps = reports.findIndex(r => r.provisional.n);
    assert.ok(perhaps >= 0 && perhaps < first && reports[perhaps].provisional.n < known, `${perhaps} ${first}`);
    assert.ok(reports.slice(first).every(r => r.provisional.n === 0));
    t.diagnostic(`${reports[perhaps].provisional.n} are provisional ${(reports[first].heard_s - reports[perhaps].heard_s).toFixed(1)} s before`);
    const marks = reports.flatMap((r, k) => r.marked.map(({t_s}) => ({t_s, k})));
    t.diagnostic(`${reports.length} detections; the first ${known} bounces are marked together, ${Math.max(...marks.filter(m => m.k > first).map(m => reports[m.k].heard_s - m.t_s)).toFixed(2)} s of sound follow a later one at most before it is marked`);
    for (const {t_s, k} of marks.filter(m => m.k > first))
      assert.ok(reports.slice(0, k).filter(r => r.heard_s > t_s + kBeyond_s).length < 2, `${t_s}`);
    for (const {t_s} of truth.filter(impact => impact.t_s < kEnd_s - kStep_s - kBeyond_s))
      assert.equal(marks.filter(m => Math.abs(m.t_s - t_s) < 1e-3).length, 1, `${t_s}`);
  });

  test('what is refused is said in words of the page', () => {
    const tables = {numbers: '1, .81, .66, .53', rises: '0.1\n0.7\n1.2\n1.6', words: 'a b c', zero: '1 0.8 0 0.5', unit: '1 m, 0.8 m', speeds: 'v (m/s)\n1\n0.9\n0.8', percent: 'v (m/s),e\n1,89\n0.9,90\n0.8,88', units: 'v (m/s),e (m/s)\n1,0.9\n0.9,0.81\n0.8,0.7',
                    drops: 'drop,drop,t (s)\n1,1,0.1\n1,1,0.5\n1,1,0.9', own: 'recording,drop,impact,t_s\na,0,0,1\na,0,1,0.5', frames: `t (s)\n${[...Array(20).keys()].map(k => k / 30).join('\n')}`};
    const options = [{}, {as: 'heights', unit: 's'}, {as: 'times', unit: 'm'}, {as: 'intervals', unit: 'ms'}, {columns: 'v_in=1,v_out=2'}, {columns: 'v=1,eps=2'}, {'drop-height': 1e5}, {gravity: 0}, {ball: 'steel:0mm'}, {ball: 'none'}, {plate: 'none'}];
    let refused = 0;
    for (const [name, table] of Object.entries(tables))
      for (const told of options)
        try {
          module.analyzeTimes(new TextEncoder().encode(table), name, JSON.stringify(told));
        } catch (error) {
          ++refused;
          for (const text of [error.message, error.question?.text ?? '']) assert.ok(!/--|COLUMN|bouncelab/.test(plain(text)), plain(text));
        }
    assert.ok(refused > 60, `${refused}`);
  });

  test('a simulated scatter is that of its closed form within the errors of counting', () => {
    const options = {drops: 60, impacts: 95, asperities: 20000, 'radius-law': 'uniform:1e-3,3e-3', seed: 3, ball: 'steel:6mm', plate: 'glass', drag: true};
    const theory = JSON.parse(module.scatter(JSON.stringify(options)));
    assert.equal(theory.n_drops, 60);
    assert.deepEqual(theory.densities.map(d => d.v_mps), [0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1]);
    // q = c s2: 5/7 of half the root of pi w/N, but for the share exp(-N w/4) = 5e-5 of places that no asperity of radii
    // from 1e-3 on covers higher than that (docs/physics.md, section 7); the ball is solid
    assert.ok(Math.abs(theory.q / (5 / 7 * 0.5 * Math.sqrt(Math.PI * 2e-3 / 20000)) - 1) < 5e-5, `${theory.q}`);
    for (const d of theory.densities) {
      const n = d.simulated_counts.length, begin = d.eps_edges[0], width = d.eps_edges[1] - begin, expected = Array(n).fill(0);
      for (let k = 0; k + 1 < d.eps.length; ++k) {
        const area = (d.density[k] + d.density[k + 1]) / 2 * (d.eps[k + 1] - d.eps[k]);
        expected[Math.min(n - 1, Math.floor(((d.eps[k] + d.eps[k + 1]) / 2 - begin) / width))] += area;
      }
      // all but exp(-5) of either side, by trapezia of a sixteenth of a mean distance: h^2/12 = 3e-4
      const integral = expected.reduce((a, b) => a + b);
      assert.ok(Math.abs(integral - (1 - Math.exp(-5))) < 1e-3, `${d.v_mps} m/s: ${integral}`);
      const tested = expected.map((e, k) => [e * d.n_simulated, d.simulated_counts[k]]).filter(([e]) => e >= 5);
      const chi2 = tested.reduce((sum, [e, found]) => sum + (found - e) ** 2 / e, 0);
      // Wilson and Hilferty's quantile of .999; impacts of a drop share their reservoir, which makes errors of counts up
      // to 1.65 times those of Poisson's (docs/physics.md, section 7)
      const f = tested.length, bound = f * (1 - 2 / (9 * f) + 3.09 * Math.sqrt(2 / (9 * f))) ** 3;
      assert.ok(tested.length > 10 && chi2 < 1.65 ** 2 * bound, `${d.v_mps} m/s: chi2 ${chi2} of ${f}`);
    }
    const spread = d => d.eps_edges.at(-1) - d.eps_edges[0];
    assert.ok(spread(theory.densities[0]) > spread(theory.densities[7]), 'slow impacts scatter more');
  });

  test('of a ball whose smooth sphere touches there is no closed form', () => {
    const theory = JSON.parse(module.scatter(JSON.stringify({drops: 2, impacts: 20, asperities: 20000, 'radius-law': 'constant:1e-5', seed: 1})));
    // exp(-N r/2): asperities lie too far apart
    assert.ok(Math.abs(theory.smooth_share - Math.exp(-0.1)) < 1e-3, `${theory.smooth_share}`);
    assert.deepEqual(theory.densities, []);
  });

  test('a WAV file holds the samples as they are, read back the same', () => {
    const samples = Float32Array.of(0.25, -0.5, 1.75, -2, 1e-30, 0), bytes = module.wav(samples, 44100, 2);
    const read = module.readSound(bytes, 'a.wav');
    assert.deepEqual([...read.samples], [...samples]);
    assert.equal(read.rate_hz, 44100);
    assert.equal(read.n_channels, 2);
    for (const [rate, channels] of [[0.5, 1], [44100.5, 1], [44100, 4], [44100, 0]]) assert.throws(() => module.wav(samples, rate, channels), Error, `${rate} ${channels}`);
  });

  test('a file that nobody here can read is refused in one sentence that asks for nothing to be installed', () => {
    for (const bytes of [new TextEncoder().encode('RIFF\x10\0\0\0WAVEnonsense'), Uint8Array.from({length: 5000}, (_, k) => (k * k) % 251)])
      assert.throws(() => module.readSound(bytes, 'a.wav'), error => /^a\.wav: /.test(error.message) && !/install|ffmpeg|libsndfile|\n/.test(error.message), bytes.length);
  });

  test('a workbook is named as such, whatever its name', () => {
    const zip = new TextEncoder().encode(`PK\x03\x04${' '.repeat(26)}[Content_Types].xml`), xls = Uint8Array.of(0xD0, 0xCF, 0x11, 0xE0, 0xA1, 0xB1, 0x1A, 0xE1);
    for (const bytes of [zip, xls]) {
      assert.ok(module.holdsTimes(bytes));
      assert.throws(() => module.analyzeTimes(bytes, 'lab.csv', '{}'), {message: 'lab.csv: is a workbook: save the sheet as CSV'});
    }
  });

  test('text of any encoding is read', () => {
    const text = `\uFEFFZeit (s);µ\n${[0, 1, 1.9, 2.71, 3.439].map(t => `${t};ä\n`).join('')}`.replaceAll('.', ',');
    const wide = (n, little) => Uint8Array.from([...text].flatMap(c => [...Array(n).keys()].map(k => (c.codePointAt(0) >> 8 * (little ? k : n - 1 - k)) & 255)));
    for (const bytes of [new TextEncoder().encode(text), wide(2, true), wide(2, false), wide(4, true), wide(4, false), wide(1, true).slice(1)]) {
      assert.ok(module.holdsTimes(bytes));
      assert.match(module.analyzeTimes(bytes, 'a.csv', '{}').taken_for, /times in s \(column 'Zeit \(s\)', ';' between, decimal comma\): 5 impacts/);
    }
  });

  test('sound that comes from a lossy coding is warned of as by the program, also where marks are given', () => {
    const {samples, rate_hz} = module.readSound(readFileSync(clean), 'clean.flac'), sound = [samples.slice(0, 5 * rate_hz), rate_hz, 1, 'clean.m4a'];
    const text = 'lossy coding (AAC): times may be off by more than their stated errors; record as WAV or FLAC', options = JSON.stringify({'lossy-coding': 'AAC'});
    const found = module.analyze(...sound, options), warnings = analysis => JSON.parse(analysis.summary).notes.map(note => note.text);
    assert.ok(warnings(found).includes(text), `${warnings(found)}`);
    assert.equal(JSON.parse(found.summary).recordings[0].lossy_coding, 'AAC');
    assert.ok(warnings(module.analyzeOnsets(found.onsets, ...sound, options)).includes(text));
    assert.ok(!warnings(module.analyze(...sound, '{}')).some(w => /lossy/.test(w)));
  });
});
