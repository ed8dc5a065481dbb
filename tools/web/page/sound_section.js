// SPDX-License-Identifier: GPL-3.0-or-later
// The sound and its marks: listen, select, drag, add, delete, undo. Every change asks for another fit.
import {Marks} from './marks.js';
import {Player} from './player.js';
import {SoundView} from './sound_view.js';

const kLongPress_ms = 500;

export class SoundSection {
  /// @param host  element; @param changed  is called with the marks after each change
  constructor(host, changed) {
    this.changed = changed;
    this.player = new Player();
    this.player.onEnd = () => this.follow();
    const overview = element('canvas', {id: 'overview', 'aria-hidden': 'true'});
    this.detail = element('canvas', {id: 'detail', tabindex: '0', role: 'slider', 'aria-label': 'Time of the selected bounce', 'aria-valuemin': '0', 'aria-valuemax': '1', 'aria-valuenow': '0'});
    this.says = element('p', {id: 'mark-says', 'aria-live': 'polite'});
    const button = (id, label, hint, action) => {
      const b = element('button', {type: 'button', id, title: hint, ...(/\w/.test(label) ? {} : {'aria-label': hint})}, label);
      b.addEventListener('click', action);
      return b;
    };
    this.buttons = {
      all: button('play-all', '▶ All', 'Play the whole sound', () => this.player.playing ? this.player.stop() : this.playAll()),
      one: button('play-one', '▶ Bounce', 'Play 0.2 s around the selected bounce', () => this.playOne()),
      previous: button('mark-previous', '←', 'Previous bounce', () => this.step(-1)),
      next: button('mark-next', '→', 'Next bounce', () => this.step(1)),
      closer: button('zoom-in', '+', 'Magnify', () => this.zoom(0.5)),
      wider: button('zoom-out', '−', 'Show more', () => this.zoom(2)),
      add: button('mark-add', 'Add', 'Add a bounce in the middle of the part shown', () => this.add((this.view.begin_s + this.view.end_s) / 2)),
      remove: button('mark-delete', 'Delete', 'Delete the selected bounce', () => this.remove()),
      undo: button('mark-undo', 'Undo', 'Undo the last change', () => this.undo()),
    };
    const help = 'Above the whole sound, below a part of it. Drag a mark to move it; double click or press long to add one. Keys: ← → move, Page Up and Down select, Delete, Enter plays, + − magnify.';
    host.append(overview, this.detail, this.says, element('div', {class: 'tools', role: 'group', 'aria-label': 'Bounces'},
        [['all', 'one'], ['previous', 'next', 'closer', 'wider'], ['add', 'remove', 'undo']].map(names => element('span', {}, names.map(name => this.buttons[name])))), element('p', {class: 'caption'}, help));
    this.view = new SoundView(overview, this.detail);
    this.pointers(overview);
    this.detail.addEventListener('keydown', event => this.key(event));
  }

  load(mono, envelope, rate_hz, list) {
    this.player.load(mono, rate_hz);
    this.marks = this.view.marks = new Marks(list);
    this.view.position_s = null;
    this.view.load(mono, envelope, rate_hz);
    this.detail.setAttribute('aria-valuemax', this.view.duration_s.toFixed(6));
    if (this.marks.list.length < 2) this.view.show(0, this.view.duration_s);
    else this.view.show(list[0].t_s - 0.1 * this.width4(), list[0].t_s + this.width4());
    this.update();
  }
  /// Time from the first mark to beyond the fifth.
  width4() { const l = this.marks.list; return (l[Math.min(4, l.length - 1)].t_s - l[0].t_s) * 1.15; }

  update() {
    const {list, selected, current, history} = this.marks;
    this.view.draw();
    const sigma = current && current.sigma_t_s !== '' ? ` ± ${number(1e6 * Number(current.sigma_t_s), 2)} µs` : '';
    const text = !current ? 'No bounce is marked.' : `Bounce ${current.impact}${new Set(list.map(m => m.drop)).size > 1 ? ` of drop ${current.drop}` : ''}: ${current.t_s.toFixed(6)} s${sigma}` +
        (current.flags ? ` (${current.flags.replaceAll('|', ', ').replaceAll('_', ' ')})` : '') + `, ${selected + 1} of ${list.length}`;
    this.says.textContent = text;
    this.detail.setAttribute('aria-valuenow', (current?.t_s ?? 0).toFixed(6));
    this.detail.setAttribute('aria-valuetext', text);
    for (const name of ['one', 'remove']) this.buttons[name].disabled = !current;
    this.buttons.previous.disabled = selected <= 0;
    this.buttons.next.disabled = selected >= list.length - 1;
    this.buttons.undo.disabled = !history.length;
  }
  changedMarks() { this.update(); this.changed(this.marks.list); }

  /// The selected mark in view.
  reveal() {
    const t = this.marks.current?.t_s, half = (this.view.end_s - this.view.begin_s) / 2;
    if (t !== undefined && (t < this.view.begin_s + 0.1 * half || t > this.view.end_s - 0.1 * half)) this.view.show(t - half, t + half);
  }
  step(n) { this.marks.step(n); this.reveal(); this.update(); }
  zoom(factor) {
    const t = this.marks.current?.t_s;
    const within = t > this.view.begin_s && t < this.view.end_s;
    this.view.zoom(factor, within ? t : undefined);
  }
  add(t_s) { this.marks.add(t_s); this.changedMarks(); }
  remove() { if (!this.marks.current) return; this.marks.remove(); this.reveal(); this.changedMarks(); }
  undo() { this.marks.undo(); this.reveal(); this.changedMarks(); }
  move(t_s) { if (!this.marks.current) return; this.marks.move(Math.max(0, Math.min(this.view.duration_s, t_s))); this.reveal(); this.changedMarks(); }
  playOne() { if (this.marks.current) { this.player.around(this.marks.current.t_s); this.follow(); } }
  playAll() { this.player.all(); this.follow(); }

  /// A line at the place that is played.
  follow() {
    cancelAnimationFrame(this.following);
    const step = () => {
      this.view.position_s = this.player.position_s;
      this.view.draw();
      this.buttons.all.textContent = this.player.playing ? '■ Stop' : '▶ All';
      if (this.player.playing) this.following = requestAnimationFrame(step);
    };
    step();
  }

  key(event) {
    const pixel = (this.view.end_s - this.view.begin_s) / this.detail.clientWidth, step = pixel * (event.shiftKey ? 10 : 1), t = this.marks.current?.t_s;
    const action = {
      ArrowLeft: () => this.move(t - step), ArrowRight: () => this.move(t + step), PageUp: () => this.step(-1), PageDown: () => this.step(1), Home: () => this.step(-Infinity), End: () => this.step(Infinity),
      Delete: () => this.remove(), Backspace: () => this.remove(), Enter: () => this.playOne(), '+': () => this.zoom(0.5), '-': () => this.zoom(2), Insert: () => this.buttons.add.click(),
    }[event.key];
    if (!action || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    action();
  }

  pointers(overview) {
    overview.addEventListener('pointerdown', event => {
      overview.setPointerCapture(event.pointerId);
      const half = (this.view.end_s - this.view.begin_s) / 2;
      const go = e => { const t = e.offsetX / overview.clientWidth * this.view.duration_s; this.view.show(t - half, t + half); };
      go(event);
      overview.onpointermove = go;
    });
    for (const end of ['pointerup', 'pointercancel']) overview.addEventListener(end, () => { overview.onpointermove = null; });
    const detail = this.detail, view = this.view;
    detail.addEventListener('dblclick', event => this.add(view.timeAt(event.offsetX)));
    detail.addEventListener('contextmenu', event => event.preventDefault());  // a long press would bring it
    detail.addEventListener('wheel', event => {
      if (!event.ctrlKey) return;  // the page scrolls; with Ctrl, or two fingers on a touchpad, the sound is magnified
      event.preventDefault();
      view.zoom(Math.exp(event.deltaY / 200), view.timeAt(event.offsetX));
    }, {passive: false});
    detail.addEventListener('pointerdown', event => {
      const near = event.pointerType === 'touch' ? 20 : 8, begin = {x: event.offsetX, from: view.begin_s, to: view.end_s};
      const nearest = this.marks.list.map((m, k) => ({k, d: Math.abs(view.xAt(m.t_s) - begin.x)})).sort((a, b) => a.d - b.d)[0];
      const grabbed = nearest && nearest.d <= near ? nearest.k : -1;
      detail.setPointerCapture(event.pointerId);
      let far = false;
      const longPress = setTimeout(() => { if (!far && grabbed < 0 && event.pointerType === 'touch') { finish(); this.add(view.timeAt(begin.x)); } }, kLongPress_ms);
      if (grabbed >= 0) { this.marks.selected = grabbed; this.update(); }
      const finish = () => { clearTimeout(longPress); detail.onpointermove = detail.onpointerup = detail.onpointercancel = null; view.dragged = null; };
      detail.onpointermove = e => {
        if (!far && Math.abs(e.offsetX - begin.x) < 3) return;
        far = true;
        const shift = (e.offsetX - begin.x) / detail.clientWidth * (begin.to - begin.from);
        if (grabbed >= 0) { view.dragged = {index: grabbed, t_s: this.marks.list[grabbed].t_s + shift}; view.draw(); } else view.show(begin.from - shift, begin.to - shift);
      };
      detail.onpointerup = () => { const dragged = view.dragged; finish(); if (dragged) this.move(dragged.t_s); };
      detail.onpointercancel = () => { finish(); view.draw(); };
    });
  }
}
