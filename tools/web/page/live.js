// SPDX-License-Identifier: GPL-3.0-or-later
// Detection while the sound comes in: what was recorded so far is detected again and again, as often as the machine can.

/// A detection may take this long, so that a bounce is shown well within half a second; the window of sound is as long as
/// fits, but holds ten intervals of the ball that bounces, more than the seven bounces or so by which a ball is known; before
/// one is known, or of a slow one, seven bounces of a ball dropped from a metre. Marks before the window stay as they were found.
const kBudget_s = 0.2, kIntervals = 10, kLeastWindow_s = 1, kBeforeBall_s = 6;
/// New sound that is worth another detection.
const kLeastNew_s = 0.08;
/// Two times of one impact in successive detections are closer than this: a tenth of the shortest intervals detected.
const kSame_s = 1e-3;
/// What is found so near to the beginning of the window may be the rest of a sound that was cut: earlier marks stay.
const kEdge_s = 0.05;
/// The ball is at rest when so many expected intervals bring nothing: a single impact is missed with a probability of .07
/// (p_D = .93, docs/glossary.md), four in succession with 2e-5. Not before a second: an impact is found some time after it sounds.
const kMissedIntervals = 4, kLeastWait_s = 1;

export class Live {
  constructor(module, rate_hz, gravity_mps2, report) {
    Object.assign(this, {module, rate_hz, gravity_mps2, report});
    this.samples = new Float32Array(60 * rate_hz);
    this.n = this.n_detected = 0;
    this.arrivals = [];
    this.onsets = [];
    this.n_drops = 0;
    this.cost = 0;  // seconds of computation per second of sound
    this.running = true;
  }

  take(chunk) {
    if (this.n + chunk.length > this.samples.length) {
      const larger = new Float32Array(2 * this.samples.length);
      larger.set(this.samples);
      this.samples = larger;
    }
    this.samples.set(chunk, this.n);
    this.n += chunk.length;
    this.arrivals.push({end: this.n, at: performance.now()});
    if (this.waiting || this.n - this.n_detected < kLeastNew_s * this.rate_hz) return;
    this.waiting = true;
    setTimeout(() => { this.waiting = false; if (this.running) this.detect(); }, 0);  // after the chunks that wait already
  }

  all() { return this.samples.slice(0, this.n); }
  end() { this.running = false; }

  detect() {
    const begin = performance.now(), n = this.n, longest = this.cost > 0 ? Math.max(this.leastWindow_s(), kBudget_s / this.cost) : Infinity;
    const from = Math.max(0, n - Math.floor(longest * this.rate_hz)), from_s = from / this.rate_hz;
    this.n_detected = n;
    const {summary, onsets: heard} = this.module.detect(this.samples.slice(from, n), this.rate_hz, 1, 'microphone', '{}');
    const doubtful = new Set((JSON.parse(summary).recordings[0].drops ?? []).flatMap((drop, k) => drop.doubtful ? [k] : []));
    const all = Array.from(heard.t_s, (t_s, k) => ({t_s: t_s + from_s, drop: heard.drop[k], impact: heard.impact[k]}));
    const onsets = areDoubtful => all.filter(o => doubtful.has(o.drop) === areDoubtful);
    const marked = this.merge(onsets(false), from_s);
    // drops that are not yet ten times as probable as anything else: of this detection alone, the next one may drop them
    const provisional = onsets(true).filter(o => !this.onsets.some(mark => Math.abs(mark.t_s - o.t_s) < kSame_s));
    const seconds = (performance.now() - begin) / 1e3;
    this.cost = seconds / Math.max(0.5, (n - from) / this.rate_hz);
    this.report({heard_s: n / this.rate_hz, seconds, marked, points: this.points(this.onsets), provisional: {n: provisional.length, points: this.points(provisional)}, n_onsets: this.onsets.length, last_s: this.onsets.at(-1)?.t_s ?? null, rest: this.atRest(n / this.rate_hz)});
  }

  /// Marks of this detection replace those of earlier ones within its window. Returns those that are new, with the time
  /// from their sound until now.
  merge(fresh, from_s) {
    const before = this.onsets, drops = new Map();
    const known = t => before.find(o => Math.abs(o.t_s - t) < kSame_s);
    for (const o of fresh) {
      const old = known(o.t_s);
      if (old && !drops.has(o.drop)) drops.set(o.drop, old.drop);
    }
    for (const o of fresh) {
      if (!drops.has(o.drop)) drops.set(o.drop, this.n_drops++);
      o.drop = drops.get(o.drop);
    }
    const edge_s = from_s > 0 ? from_s + kEdge_s : 0, kept = before.filter(o => o.t_s < edge_s);
    fresh = fresh.filter(f => f.t_s >= edge_s - kSame_s && !kept.some(o => Math.abs(o.t_s - f.t_s) < kSame_s));
    this.onsets = [...kept, ...fresh].sort((a, b) => a.t_s - b.t_s);
    // a drop that goes on over the beginning of the window: its numbers go on from those kept
    for (const drop of new Set(fresh.map(o => o.drop))) {
      const last = kept.filter(o => o.drop === drop).at(-1), first = fresh.find(o => o.drop === drop);
      if (!last) continue;
      const shift = last.impact + 1 - first.impact;
      for (const o of fresh) if (o.drop === drop) o.impact += shift;
    }
    return fresh.filter(o => !known(o.t_s)).map(({t_s}) => ({t_s, lag_s: this.since(t_s)}));
  }

  /// Seconds since a time of the sound came in.
  since(t_s) {
    const chunk = this.arrivals.find(a => a.end >= t_s * this.rate_hz);
    return (performance.now() - chunk.at) / 1e3 + chunk.end / this.rate_hz - t_s;
  }

  /// ε = T'/T at v = g T/2 of each impact with an interval on either side; nothing is taken out.
  points(onsets) {
    const v = [], eps = [];
    for (let k = 1; k + 1 < onsets.length; ++k) {
      const [a, b, c] = [onsets[k - 1], onsets[k], onsets[k + 1]];
      if (a.drop !== b.drop || b.drop !== c.drop || b.impact !== a.impact + 1 || c.impact !== b.impact + 1) continue;
      v.push(this.gravity_mps2 * (b.t_s - a.t_s) / 2);
      eps.push((c.t_s - b.t_s) / (b.t_s - a.t_s));
    }
    return {v, eps};
  }

  /// Between the last two bounces; null where these are of two drops.
  interval_s() {
    const last = this.onsets.at(-1), previous = this.onsets.at(-2);
    return previous?.drop === last?.drop && previous ? last.t_s - previous.t_s : null;
  }

  leastWindow_s() {
    const interval_s = this.interval_s(), since_s = this.n / this.rate_hz - (this.onsets.at(-1)?.t_s ?? 0);
    return interval_s === null ? kBeforeBall_s : Math.max(kLeastWindow_s, Math.min(kBeforeBall_s, since_s + kIntervals * interval_s));
  }

  atRest(heard_s) {
    const interval_s = this.interval_s();
    return this.onsets.length >= 3 && interval_s !== null && heard_s - this.onsets.at(-1).t_s > Math.max(kLeastWait_s, kMissedIntervals * interval_s);
  }
}
