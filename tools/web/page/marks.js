// SPDX-License-Identifier: GPL-3.0-or-later
// Marks that a person corrects. A mark moved or added has no standard error, amplitude or probability of its own any more:
// they are left empty, its flag is by_hand (docs/formats.md, Annotations).

const kByHand = {sigma_t_s: '', amplitude: '', snr_db: '', flags: 'by_hand', probability: ''};
const byTime = (a, b) => a.t_s - b.t_s;

export function moved(marks, index, t_s) {
  return marks.map((mark, k) => k === index ? {...mark, ...kByHand, t_s} : mark).sort(byTime);
}

/// An impact more, of the drop that it lies within, or of the nearest. It takes the number after the one before it; those
/// after it move up where no number is free.
export function added(marks, t_s) {
  const distance = drop => {
    const times = marks.filter(m => m.drop === drop).map(m => m.t_s);
    return Math.max(times[0] - t_s, t_s - times.at(-1), 0);
  };
  const drop = [...new Set(marks.map(m => m.drop))].sort((a, b) => distance(a) - distance(b))[0] ?? 0;
  const own = marks.filter(m => m.drop === drop), before = own.findLast(m => m.t_s <= t_s), after = own.find(m => m.t_s > t_s);
  const impact = before ? before.impact + 1 : Math.max(0, (after?.impact ?? 1) - 1), shift = after && after.impact <= impact ? 1 : 0;
  const shifted = marks.map(m => m.drop === drop && m.t_s > t_s ? {...m, impact: m.impact + shift} : m);
  return [...shifted, {drop, impact, t_s, ...kByHand}].sort(byTime);
}

/// An impact less: those after it in its drop move down, as there was none.
export function removed(marks, index) {
  const gone = marks[index];
  return marks.filter((_, k) => k !== index).map(m => m.drop === gone.drop && m.t_s > gone.t_s ? {...m, impact: m.impact - 1} : m);
}

export class Marks {
  constructor(list) {
    this.list = [...list].sort(byTime);
    this.history = [];
    this.selected = this.list.length ? 0 : -1;
  }
  change(list, t_s) {
    this.history.push(this.list);
    this.list = list;
    this.select(t_s);
  }
  select(t_s) {
    let best = -1;
    for (const [k, mark] of this.list.entries()) if (best < 0 || Math.abs(mark.t_s - t_s) < Math.abs(this.list[best].t_s - t_s)) best = k;
    this.selected = best;
  }
  get current() { return this.list[this.selected]; }
  step(n) { this.selected = Math.max(0, Math.min(this.list.length - 1, this.selected + n)); }
  move(t_s) { this.change(moved(this.list, this.selected, t_s), t_s); }
  add(t_s) { this.change(added(this.list, t_s), t_s); }
  remove() { const t_s = this.current.t_s; this.change(removed(this.list, this.selected), t_s); }
  undo() {
    if (!this.history.length) return;
    const t_s = this.current?.t_s ?? 0;
    this.list = this.history.pop();
    this.select(t_s);
  }
}
