// SPDX-License-Identifier: GPL-3.0-or-later
// The closed loop: a rough ball is simulated, its sound made and played, the bounces found in the sound alone and laid
// beside the truth; the scatter of many drops of the same ball beside its closed form.
import {drawDensity} from './result.js';

const $ = id => document.getElementById(id);
const kDiameter = '6mm';  // of the published experiment's ball
const kMostRows = 100;

export function simulateOptions(settings) {
  return {drops: settings.number('simulate-drops', 'The number of drops'), impacts: settings.number('simulate-impacts', 'The number of bounces'), asperities: 20000, 'radius-law': $('simulate-surface').value,
          seed: settings.number('simulate-seed', 'The number of the ball'), rate: 48000, 'snr-db': Number($('simulate-noise').value), ball: `${$('simulate-ball').value}:${kDiameter}`, plate: 'glass', drag: true};
}

/// The true time at the sensor of each impact with the mark found for it: the nearest, closer than half the way to the
/// neighbours.
export function compare(truth, marks) {
  const times = truth.t_s.map((t, k) => t + (truth.travel_time_s[k] || 0)), found = marks.map(m => m.t_s), taken = new Set();
  const rows = times.map((t, k) => {
    const half = 0.5 * Math.min(k ? t - times[k - 1] : Infinity, k + 1 < times.length ? times[k + 1] - t : Infinity);
    let best = -1;
    for (const [j, f] of found.entries()) if (!taken.has(j) && Math.abs(f - t) < half && (best < 0 || Math.abs(f - t) < Math.abs(found[best] - t))) best = j;
    if (best >= 0) taken.add(best);
    return {truth_s: t, found_s: best < 0 ? null : found[best], flags: best < 0 ? '' : marks[best].flags};
  });
  // what all times of a drop share is no error of an interval
  const mean = list => list.reduce((a, b) => a + b, 0) / list.length, drops = [...new Set(truth.drop)];
  for (const drop of drops) {
    const own = rows.filter((r, k) => truth.drop[k] === drop && r.found_s !== null), shift = own.length ? mean(own.map(r => r.found_s - r.truth_s)) : 0;
    for (const row of own) row.error_s = row.found_s - row.truth_s - shift;
  }
  const errors = rows.filter(r => r.found_s !== null).map(r => r.error_s), freedom = errors.length - drops.length;
  return {rows, n_missed: rows.filter(r => r.found_s === null).length, n_invented: found.length - taken.size,
          rms_s: freedom > 0 ? Math.sqrt(errors.reduce((sum, e) => sum + e * e, 0) / freedom) : null};
}

/// The curve that was simulated, from the module's law.
export function trueCurve(law) {
  return law ? {v: law.curve.map(p => p.v_mps), eps: law.curve.map(p => p.eps)} : null;
}

const card = (value, text) => element('div', {class: 'card'}, element('b', {}, value), element('span', {}, text));

export function showClosedLoop(simulated, marks) {
  $('closed-loop').hidden = false;
  const compared = compare(simulated.truth, marks), n = compared.rows.length;
  const body = $('closed-loop-body'), several = new Set(simulated.truth.drop).size > 1;
  body.replaceChildren(element('div', {class: 'cards'}, card(`${n - compared.n_missed} of ${n}`, 'bounces found in the sound'), card(`${compared.n_missed} / ${compared.n_invented}`, 'missed / invented'),
                                compared.rms_s === null ? [] : card(`${number(1e6 * compared.rms_s, 3)} µs`, 'typical error of a time (root mean square)')));
  const fold = element('details', {}, element('summary', {}, 'Bounce by bounce'));
  body.append(fold);
  // many rows take long to lay out: only when they are asked for, and no more than one can read
  fold.addEventListener('toggle', () => table('', ['bounce', 'true time', 'found', 'difference'],
        compared.rows.slice(0, kMostRows).map((r, k) => [several ? `${simulated.truth.drop[k]}.${simulated.truth.impact[k]}` : String(simulated.truth.impact[k]), `${r.truth_s.toFixed(6)} s`,
                                                         r.found_s === null ? 'missed' : `${r.found_s.toFixed(6)} s`, r.found_s === null ? '–' : `${number(1e6 * r.error_s, 2)} µs`]),
        'Times when the sound of each bounce reaches the sensor. The difference is less its mean of the drop: ε follows from intervals, which do not contain it.' +
        (n > kMostRows ? ` The first ${kMostRows} of ${n}.` : ''), fold), {once: true});
}

/// Drops without sound, enough for a histogram in each window of speed, of as many bounces as in the published experiment.
const kSilentDrops = 100, kSilentBounces = 95;
/// A distribution of fewer bounces says nothing.
const kLeastBounces = 100;
const kSpeeds_mps = [0.4, 0.6, 1.0];  // of the windows of the fit

export const scatterOptions = options => ({...options, drops: kSilentDrops, impacts: kSilentBounces});

/// @param theory  of the module's scatter(): no densities where the closed form does not apply
export function showScatter(theory) {
  const shown = theory.densities.filter(d => d.n_simulated >= kLeastBounces && kSpeeds_mps.includes(d.v_mps));
  $('scatter').hidden = false;
  $('scatter-plots').replaceChildren(...shown.map((_, k) => element('div', {id: `scatter-${k}`})));
  $('scatter-caption').textContent = shown.length ?
      `The same ball, dropped ${theory.n_drops} times without sound. Points: how often each ε occurred, with Poisson errors, on a logarithmic axis. ` +
          `Dashes: the closed form, two exponentials about ε(v) that follow from the roughness of the ball alone (q = ${number(theory.q, 3)}); nothing is fitted.` :
      `${number(100 * theory.smooth_share, 2)} % of the contacts of this ball are with the smooth sphere between its asperities; the closed form is that of a ball that is rough everywhere: choose a rougher one.`;
  for (const [k, d] of shown.entries())
    drawDensity($(`scatter-${k}`), d.v_mps, d.n_simulated, {eps_edges: d.eps_edges, counts: d.simulated_counts}, {kind: 'truth', x: d.eps, y: d.density});
}
