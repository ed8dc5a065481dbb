# SPDX-License-Identifier: GPL-3.0-or-later
"""Sounds that hold no ball, first kind: one stroke and its decay. Each function makes one recording: (rate_hz, sound)."""
import numpy as np

import waves

RATE_HZ = 44100


def finished(rng, sound, level=None):
    level = 10**rng.uniform(-5, -2.5) if level is None else level
    sound = 0.7 * sound / np.max(np.abs(sound))
    return RATE_HZ, sound + level * waves.noise(rng, len(sound), RATE_HZ, rng.choice([0, 1.0]))


def one_stroke(rng, struck, duration_s):
    voice = waves.Voice(struck, 0.1, duration_s)
    return waves.struck_at(voice, [rng.uniform(0.05, 0.3)], [1.0], [1.0], duration_s, rng)[0]


def drum(rng):
    """Ratios of a circular membrane; each mode is a pair some hertz apart, which beats."""
    ratios = np.array([1, 1.594, 2.136, 2.296, 2.653, 2.918, 3.156, 3.501, 3.6, 4.06, 4.15, 4.6])
    f_hz = rng.uniform(60, 300) * ratios
    pair = np.concatenate([f_hz, f_hz + rng.uniform(1, 12, len(f_hz))])
    tau_s = rng.uniform(0.1, 0.6) * (pair / f_hz[0])**-rng.uniform(0.3, 1.0)
    struck = waves.Body(RATE_HZ, pair, tau_s, rng.standard_normal(len(pair)) * (pair / f_hz[0])**-0.5, rng.uniform(0.3e-3, 3e-3))
    return finished(rng, one_stroke(rng, struck, rng.uniform(1, 3)))


def bell(rng):
    """Few modes of long decay in close pairs: the envelope swells and fades."""
    f_hz = rng.uniform(200, 1500) * np.cumsum(rng.uniform(0.3, 1.2, 8))
    f_hz = f_hz[f_hz < 0.4 * RATE_HZ]
    pair = np.concatenate([f_hz, f_hz + rng.uniform(0.5, 8, len(f_hz))])
    struck = waves.Body(RATE_HZ, pair, rng.uniform(0.3, 1.5) * (pair / pair[0])**-0.5, rng.standard_normal(len(pair)), 1e-4)
    return finished(rng, one_stroke(rng, struck, rng.uniform(2, 4)))


def cymbal(rng):
    """Thousands of modes: noise in bands that decay each at its own rate, slowest in the middle, with a slow random swell."""
    n = int(rng.uniform(2, 5) * RATE_HZ)
    t = np.arange(n) / RATE_HZ - rng.uniform(0.05, 0.3)
    sound = np.zeros(n)
    f_hz = np.fft.rfftfreq(n, 1 / RATE_HZ)
    for centre in 300 * 2**np.arange(0, 6, 0.5):
        band = np.exp(-0.5 * (np.log2(np.maximum(f_hz, 1) / centre) / 0.35)**2)
        grain = np.fft.irfft(band * np.exp(2j * np.pi * rng.random(len(f_hz))), n)
        swell = 1 + 0.3 * np.sin(2 * np.pi * rng.uniform(1, 9) * t + rng.uniform(0, 6))
        rise = 1 - np.exp(-np.maximum(t, 0) / rng.uniform(1e-4, 2e-2))
        sound += grain / np.std(grain) * swell * rise * np.exp(-np.maximum(t, 0) / rng.uniform(0.1, 1.0)) * rng.uniform(0.2, 1)
    return finished(rng, sound)


def jingles(rng):
    """Tambourine, keys, shaker: one stroke sets off dozens of small ones at random times, ever fewer."""
    duration_s = rng.uniform(1, 2)
    t_s = np.sort(0.2 + np.concatenate([[0], rng.exponential(rng.uniform(0.05, 0.2), rng.integers(15, 60))]))
    t_s = t_s[t_s < duration_s - 0.1]
    struck = waves.body(rng, RATE_HZ, 2000, 15e3, 30, (50, 400), 4e-5)
    size = np.exp(-(t_s - 0.2) / rng.uniform(0.1, 0.3)) * rng.lognormal(0, 0.5, len(t_s))
    return finished(rng, waves.struck_at(waves.Voice(struck, 0.6), t_s, np.ones(len(t_s)), size, duration_s, rng)[0])


def clap(rng, n):
    """A burst of noise of some milliseconds, as one hand clap."""
    sound = np.zeros(n)
    at, length = int(rng.uniform(0.05, 0.3) * RATE_HZ), int(rng.uniform(2e-3, 8e-3) * RATE_HZ)
    burst = rng.standard_normal(10 * length) * np.exp(-np.arange(10 * length) / length)
    waves.add(sound, np.convolve(burst, np.hanning(9))[:-8], at)
    return sound


def hall(rng):
    """A clap and the smooth decay of a large room."""
    n = int(rng.uniform(2, 4) * RATE_HZ)
    rt60_s, t = rng.uniform(0.5, 3), np.arange(n) / RATE_HZ
    tail = 0.05 * rng.standard_normal(n) * 10**(-3 * t / rt60_s)
    tail[0] = 1
    return finished(rng, waves.convolved(clap(rng, n), tail))


def flutter(rng):
    """A clap between two walls: echoes at equal times, each duller and fainter than the last."""
    n = int(2.5 * RATE_HZ)
    response, delay, gain = np.zeros(n), rng.uniform(6e-3, 90e-3), rng.uniform(0.6, 0.9)
    response[0] = 1
    for k in range(1, int(2.0 / delay)):
        width = 2 * k + 1
        waves.add(response, gain**k * np.hanning(width + 2)[1:-1] / np.sum(np.hanning(width + 2)), int(k * delay * RATE_HZ) - k)
    return finished(rng, waves.convolved(clap(rng, n), response))


def shoebox(rng):
    """A clap in a bare rectangular room: mirror sources, whose echoes come denser and fainter."""
    n = int(1.5 * RATE_HZ)
    size, source, ear = rng.uniform(3, 12, 3), rng.random(3), rng.random(3)
    gain, response = rng.uniform(0.5, 0.85), np.zeros(n)
    order = np.arange(-4, 5)
    i, j, k = (grid.ravel() for grid in np.meshgrid(order, order, order))
    place = np.stack([i, j, k], 1)
    mirror = np.where(place % 2 == 0, source, 1 - source) + place
    distance = np.sqrt((((mirror - ear) * size)**2).sum(1))
    np.add.at(response, np.minimum(n - 1, (distance / 343 * RATE_HZ).astype(int)), gain**np.abs(place).sum(1) / distance)
    response[-1] = 0
    return finished(rng, waves.convolved(clap(rng, n), response))


STROKES = {"drum": drum, "bell": bell, "cymbal": cymbal, "jingles": jingles, "hall": hall, "flutter echo": flutter, "shoebox room": shoebox}
