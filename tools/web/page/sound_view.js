// SPDX-License-Identifier: GPL-3.0-or-later
// The sound on two canvases: all of it, and a part at any magnification, with the marks.
import {kBlock} from './sound.js';
import {roundTicks} from './picture.js';

const colour = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

export class SoundView {
  constructor(overview, detail) {
    Object.assign(this, {overview, detail, begin_s: 0, end_s: 1});
    const redraw = () => this.draw();
    new ResizeObserver(redraw).observe(overview);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
  }

  load(mono, envelope, rate_hz) {
    Object.assign(this, {mono, envelope, rate_hz, duration_s: mono.length / rate_hz});
    this.level = 1e-9;
    for (let b = 0; b < envelope.lo.length; ++b) this.level = Math.max(this.level, envelope.hi[b], -envelope.lo[b]);
  }

  /// The part that the detail shows, within the sound, not shorter than 1 ms.
  show(begin_s, end_s) {
    const length = Math.max(1e-3, Math.min(this.duration_s, end_s - begin_s));
    this.begin_s = Math.max(0, Math.min(this.duration_s - length, begin_s));
    this.end_s = this.begin_s + length;
    this.draw();
  }
  zoom(factor, about_s = (this.begin_s + this.end_s) / 2) {
    this.show(about_s - (about_s - this.begin_s) * factor, about_s + (this.end_s - about_s) * factor);
  }
  timeAt(x_px) { return this.begin_s + x_px / this.detail.clientWidth * (this.end_s - this.begin_s); }
  xAt(t_s) { return (t_s - this.begin_s) / (this.end_s - this.begin_s) * this.detail.clientWidth; }

  /// Extremes of the samples from i to j.
  extremes(i, j) {
    let lo = Infinity, hi = -Infinity;
    const end = Math.min(j, this.mono.length);
    for (let k = Math.max(0, i); k < end;) {
      if (k % kBlock === 0 && k + kBlock <= end) {
        lo = Math.min(lo, this.envelope.lo[k / kBlock]);
        hi = Math.max(hi, this.envelope.hi[k / kBlock]);
        k += kBlock;
      } else {
        lo = Math.min(lo, this.mono[k]);
        hi = Math.max(hi, this.mono[k]);
        ++k;
      }
    }
    return lo <= hi ? [lo, hi] : [0, 0];
  }

  draw() {
    if (!this.mono || !this.overview.clientWidth) return;
    cancelAnimationFrame(this.frame);
    this.frame = requestAnimationFrame(() => { this.drawOverview(); this.drawDetail(); });
  }

  canvas(node) {
    const ratio = window.devicePixelRatio || 1, width = node.clientWidth, height = node.clientHeight;
    if (node.width !== Math.round(width * ratio)) node.width = Math.round(width * ratio);
    if (node.height !== Math.round(height * ratio)) node.height = Math.round(height * ratio);
    const pen = node.getContext('2d');
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    return {pen, width, height};
  }

  wave(pen, width, top, bottom, begin_s, end_s, level) {
    const step = (end_s - begin_s) * this.rate_hz / width, middle = (top + bottom) / 2, scale = 0.47 * (bottom - top) / level;
    pen.beginPath();
    if (step > 2) {
      for (let x = 0; x < width; ++x) {
        const from = Math.floor(begin_s * this.rate_hz + x * step), [lo, hi] = this.extremes(from, Math.max(from + 1, Math.floor(begin_s * this.rate_hz + (x + 1) * step)));
        pen.moveTo(x + 0.5, middle - hi * scale - 0.4);
        pen.lineTo(x + 0.5, middle - lo * scale + 0.4);
      }
    } else {
      const first = Math.max(0, Math.floor(begin_s * this.rate_hz)), last = Math.min(this.mono.length - 1, Math.ceil(end_s * this.rate_hz));
      for (let k = first; k <= last; ++k) pen.lineTo((k - begin_s * this.rate_hz) / step, middle - this.mono[k] * scale);
    }
    pen.strokeStyle = colour('--soft');
    pen.lineWidth = 1;
    pen.stroke();
  }

  drawOverview() {
    const {pen, width, height} = this.canvas(this.overview), x = t => t / this.duration_s * width;
    this.wave(pen, width, 8, height, 0, this.duration_s, this.level);
    pen.fillStyle = colour('--no');
    for (const mark of this.marks?.list ?? []) pen.fillRect(x(mark.t_s) - 0.5, 0, 1, 8);
    pen.strokeStyle = colour('--accent');
    pen.lineWidth = 2;
    pen.strokeRect(x(this.begin_s) + 1, 1, Math.max(4, x(this.end_s) - x(this.begin_s)) - 2, height - 2);
    this.cursor(pen, this.position_s === null ? null : x(this.position_s), height);
  }

  drawDetail() {
    const {pen, width, height} = this.canvas(this.detail), axis = height - 20;
    const first = Math.floor(this.begin_s * this.rate_hz), [lo, hi] = this.extremes(first, Math.ceil(this.end_s * this.rate_hz));
    this.wave(pen, width, 18, axis, this.begin_s, this.end_s, Math.max(hi, -lo, 1e-9));
    pen.font = '12px system-ui, sans-serif';
    pen.fillStyle = colour('--soft');
    pen.textAlign = 'center';
    for (const tick of roundTicks(this.begin_s, this.end_s, Math.max(2, width / 110))) {
      const x = this.xAt(tick.at);
      if (x < 24 || x > width - 24) continue;
      pen.fillText(`${tick.text} s`, x, height - 6);
      pen.fillRect(x, axis, 1, 4);
    }
    let free = -Infinity;  // numbers of marks are left out where they would lie on each other
    for (const [k, mark] of (this.marks?.list ?? []).entries()) {
      const x = this.dragged?.index === k ? this.xAt(this.dragged.t_s) : this.xAt(mark.t_s), chosen = k === this.marks.selected;
      if (x < -20 || x > width + 20) continue;
      pen.fillStyle = colour(chosen ? '--accent' : mark.flags ? '--warn-line' : '--no');
      pen.fillRect(x - (chosen ? 1.5 : 0.75), 16, chosen ? 3 : 1.5, axis - 16);
      if (chosen || x > free) {
        pen.font = `${chosen ? '600 ' : ''}12px system-ui, sans-serif`;
        pen.fillText(String(mark.impact), Math.max(8, Math.min(width - 8, x)), 12);
        free = x + 22;
      }
    }
    this.cursor(pen, this.position_s === null || this.position_s === undefined ? null : this.xAt(this.position_s), axis);
  }

  cursor(pen, x, height) {
    if (x === null || !(x >= 0)) return;
    pen.fillStyle = colour('--yes');
    pen.fillRect(x - 1, 0, 2, height);
  }
}
