// SPDX-License-Identifier: GPL-3.0-or-later
// In the audio thread: hands on the samples as they are, with their peak and how many of them are clipped.
const kChunk = 2048;      // 43 ms at 48 kHz: the least delay that costs little
const kFullScale = 0.9995;  // 16 bit reach 1 - 2^-15 above, -1 below

class Recorder extends AudioWorkletProcessor {
  constructor() {
    super();
    this.clear();
  }
  clear() {
    this.samples = new Float32Array(kChunk);
    this.n = this.peak = this.clipped = 0;
  }
  process(inputs) {
    const input = inputs[0]?.[0];
    if (!input) return true;
    for (let i = 0; i < input.length; ++i) {
      const size = Math.abs(input[i]);
      if (size > this.peak) this.peak = size;
      if (size >= kFullScale) ++this.clipped;
      this.samples[this.n++] = input[i];
      if (this.n < kChunk) continue;
      this.port.postMessage({samples: this.samples, peak: this.peak, clipped: this.clipped}, [this.samples.buffer]);
      this.clear();
    }
    return true;
  }
}
registerProcessor('recorder', Recorder);
