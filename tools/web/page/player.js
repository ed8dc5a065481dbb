// SPDX-License-Identifier: GPL-3.0-or-later
// The sound as it is heard: all of it, or 0.2 s around a bounce as in the report.
const kBefore_s = 0.05, kAround_s = 0.2;

export class Player {
  load(samples, rate_hz) {
    this.stop();
    Object.assign(this, {samples, rate_hz, buffer: null});
  }
  play(begin_s, duration_s) {
    this.stop();
    this.context ??= new AudioContext();
    this.context.resume();
    if (!this.buffer) {
      // rates that a browser has to play are those from 8 to 96 kHz; others are played slower or faster and look the same
      this.buffer = this.context.createBuffer(1, this.samples.length, Math.max(8000, Math.min(96000, this.rate_hz)));
      this.buffer.copyToChannel(this.samples, 0);
    }
    const source = this.context.createBufferSource(), stretch = this.rate_hz / this.buffer.sampleRate;
    source.buffer = this.buffer;
    source.connect(this.context.destination);
    source.onended = () => { if (this.source === source) { this.source = null; this.onEnd?.(); } };
    source.start(0, Math.max(0, begin_s) * stretch, duration_s * stretch);
    this.source = source;
    this.begin = {at: this.context.currentTime, t_s: Math.max(0, begin_s), stretch};
  }
  around(t_s) { this.play(t_s - kBefore_s, kAround_s); }
  all() { this.play(0, this.samples.length / this.rate_hz); }
  stop() {
    const source = this.source;
    this.source = null;
    source?.stop();
  }
  get playing() { return Boolean(this.source); }
  /// Place in the sound, or null.
  get position_s() {
    return this.source ? this.begin.t_s + (this.context.currentTime - this.begin.at) / this.begin.stretch : null;
  }
}
