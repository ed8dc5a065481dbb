// SPDX-License-Identifier: GPL-3.0-or-later
// Samples in the worker: interleaved 32-bit floats, full scale 1.

/// One array of all channels from one array each.
export function interleave(channels) {
  if (channels.length === 1) return channels[0];
  const n = channels[0].length, c = channels.length, all = new Float32Array(n * c);
  for (let k = 0; k < c; ++k) for (let i = 0, channel = channels[k]; i < n; ++i) all[i * c + k] = channel[i];
  return all;
}

export function channelOf(sound, channel) {
  const n = Math.floor(sound.samples.length / sound.n_channels), mono = new Float32Array(n);
  for (let i = 0; i < n; ++i) mono[i] = sound.samples[i * sound.n_channels + channel];
  return mono;
}

export function soundSummary(sound) {
  let peak = 0;
  for (const x of sound.samples) if (x > peak) peak = x; else if (-x > peak) peak = -x;
  return {name: sound.name, rate_hz: sound.rate_hz, n_channels: sound.n_channels, format: sound.format, peak,
          duration_s: sound.samples.length / sound.n_channels / sound.rate_hz};
}

/// Samples in one step of the envelope.
export const kBlock = 256;

/// Extremes of every block of samples: what is drawn where a pixel holds more than a block.
export function envelopeOf(mono) {
  const n = Math.ceil(mono.length / kBlock), lo = new Float32Array(n), hi = new Float32Array(n);
  for (let b = 0; b < n; ++b) {
    let least = Infinity, most = -Infinity;
    for (let i = b * kBlock, end = Math.min(mono.length, i + kBlock); i < end; ++i) {
      if (mono[i] < least) least = mono[i];
      if (mono[i] > most) most = mono[i];
    }
    lo[b] = least;
    hi[b] = most;
  }
  return {lo, hi};
}
