// SPDX-License-Identifier: GPL-3.0-or-later
// What was found: the answer in sentences, ε(v), distributions, notes. (explanations, sentencesOf, pointsCaption, answerCurve, causesBox, number, element: report's answer.js, text.js)
import {drawPicture, paddedRange} from './picture.js';
import {plain} from './trouble.js';

const $ = id => document.getElementById(id);

export function showAnswer(result) {
  const [lead, ...rest] = result.answer ? sentencesOf(result.answer) : [result.message || 'No bouncing ball was found in this sound.'];
  $('answer').replaceChildren(element('p', {class: 'lead'}, plain(lead)), ...[...rest, ...(result.answer?.doubt ? [result.answer.doubt] : [])].map(s => element('p', {}, plain(s))));
  $('signs').textContent = result.answer ? explanations(result.answer) : '';
  const causes = result.fitted?.causes ?? [];
  $('why').replaceChildren(...(causes.length ? [causesBox(causes)] : []));
  const said = (result.answer?.doubt ?? '').toLowerCase(), more = result.warnings.filter(w => !said.includes(w.toLowerCase()));
  $('notes').replaceChildren(...more.map(w => element('li', {}, plain(w))));
  $('notes-section').hidden = !more.length;
}

/// Shares of the values lie below the two bounds; a single wrong mark would set the scale otherwise.
function middle(values, share) {
  const sorted = values.filter(Number.isFinite).sort((a, b) => a - b);
  if (sorted.length < 8) return sorted;
  const cut = Math.floor(share * sorted.length);
  return [sorted[cut], sorted[sorted.length - 1 - cut]];
}

/// From 0, unless all speeds are much alike.
const speedRange = speeds => { const [lo, hi] = paddedRange(speeds); return lo > 0.5 * hi ? [lo, hi] : [0, hi]; };

/// @param truth  {v, eps} of what was simulated, or null
export function drawLaw(result, truth) {
  const {samples} = result, curve = answerCurve(result.fitted), used = (samples.v_mps ?? []).map((_, k) => k).filter(k => !samples.flags?.[k] && Number.isFinite(samples.eps[k]));
  const v = used.map(k => samples.v_mps[k]), eps = used.map(k => samples.eps[k]), errors = result.fitted?.curve?.errors_over_digits ?? 1, sigma = used.map(k => errors * samples.sigma_eps?.[k]);
  const hasBand = curve.length && Number.isFinite(curve[0].lo95);
  const y = paddedRange([...middle(eps, 0.02), ...curve.flatMap(p => hasBand ? [p.lo95, p.hi95] : [p.eps])], 0.1);
  const outside = eps.filter(e => e < y[0] || e > y[1]).length;
  const known = used.map((_, k) => k).filter(k => Number.isFinite(sigma[k]));
  const layers = [{kind: 'errors', x: known.map(k => v[k]), y: [], lo: known.map(k => eps[k] - sigma[k]), hi: known.map(k => eps[k] + sigma[k])}, {kind: 'points', x: v, y: eps}];
  if (hasBand) layers.push({kind: 'band', x: curve.map(p => p.v_mps), lo: curve.map(p => p.lo95), hi: curve.map(p => p.hi95)});
  if (curve.length) layers.push({kind: 'curve', x: curve.map(p => p.v_mps), y: curve.map(p => p.eps)});
  if (truth) layers.push({kind: 'truth', x: truth.v, y: truth.eps});
  $('law-caption').textContent = (v.length ? `${pointsCaption(result.answer, /^(heights|speeds)/.exec(result.takenFor)?.[0] ?? 'times')} ` : 'No bounce has an interval on either side. ') +
      (curve.length ? `Line${hasBand ? ' and band' : ''}: ε(v), the root mean square of the bounces at each speed${hasBand ? ', with its 95 % range' : ''}. ` : '') + (truth ? 'Dashes: the ε(v) that was simulated. ' : '') +
      (outside ? `${outside} ${outside === 1 ? 'bounce lies' : 'bounces lie'} outside the picture.` : '');
  if (!v.length && !curve.length) return $('law-plot').replaceChildren();
  drawPicture($('law-plot'), {height: 320, label: `Plot: coefficient of restitution against impact speed, ${v.length} bounces`,
                              x: {title: 'normal impact speed v (m/s)', range: speedRange([...v, ...curve.map(p => p.v_mps)])}, y: {title: 'coefficient of restitution ε', range: y}, layers});
}

/// p(ε) at a speed on a logarithmic axis.
/// @param bins  {eps_edges, counts}, n: bounces in them or not; @param line  layer of the curve: {kind, x, y}
export function drawDensity(host, v_mps, n, {eps_edges, counts}, line) {
  const unit = n * (eps_edges[1] - eps_edges[0]), filled = counts.map((_, i) => i).filter(i => counts[i] > 0);
  const x = filled.map(i => (eps_edges[i] + eps_edges[i + 1]) / 2), found = filled.map(i => counts[i]);
  const top = Math.max(...found.map(c => c / unit), ...line.y);
  drawPicture(host, {
    height: 240, title: `v = ${number(v_mps, 3)} m/s, ${number(n)} bounces`, label: `Plot: distribution of ε at ${number(v_mps, 3)} m/s`,
    x: {title: 'ε', range: paddedRange(eps_edges, 0)}, y: {title: 'p(ε)', range: [0.4 / unit, 1.8 * top], log: true},
    layers: [{kind: 'errors', x, y: [], lo: found.map(c => (c - Math.sqrt(c)) / unit), hi: found.map(c => (c + Math.sqrt(c)) / unit)},
             {kind: 'points', x, y: found.map(c => c / unit)}, line]});
}

export function drawDistributions(result) {
  $('distributions').hidden = !result.histograms.length;
  $('distribution-plots').replaceChildren(...result.histograms.map((h, k) => element('div', {id: `distribution-${k}`})));
  for (const [k, h] of result.histograms.entries()) drawDensity($(`distribution-${k}`), h.v_mps, h.n, h.bins, {kind: 'curve', x: h.curve.eps, y: h.curve.density});
}
