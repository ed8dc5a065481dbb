# SPDX-License-Identifier: GPL-3.0-or-later
"""Sounds that hold no ball, second kind: rhythms and voices. Each function makes one recording: (rate_hz, sound)."""
import numpy as np

import waves
from strokes import RATE_HZ, finished


def beaten(rng, t_s, size, struck, duration_s, wander=0.3):
    voice = waves.Voice(struck, wander)
    return waves.struck_at(voice, t_s, np.ones(len(t_s)), size, duration_s, rng)[0]


def metronome(rng):
    interval_s, duration_s = rng.uniform(0.2, 1.0), 8.0
    t_s = np.arange(0.2, duration_s - 0.2, interval_s)
    t_s = t_s + 1e-4 * rng.standard_normal(len(t_s))
    return finished(rng, beaten(rng, t_s, rng.lognormal(0, 0.03, len(t_s)), waves.hard_ball(rng, RATE_HZ), duration_s, 0.05))


def hand_claps(rng):
    """Intervals that scatter by 2 to 10 %."""
    steps = rng.uniform(0.15, 0.6) * (1 + rng.uniform(0.02, 0.1) * rng.standard_normal(40))
    t_s = 0.3 + np.cumsum(np.maximum(0.05, steps))
    t_s = t_s[t_s < 9.5]
    struck = waves.body(rng, RATE_HZ, 500, 8000, 20, (3, 15), 5e-4)
    return finished(rng, beaten(rng, t_s, rng.lognormal(0, 0.3, len(t_s)), struck, 10.0, 0.6))


def accelerando(rng):
    """A beat that quickens, evenly loud, with a hand's scatter of 2 to 5 %."""
    n = rng.integers(12, 30)
    steps = np.linspace(rng.uniform(0.45, 0.7), rng.uniform(0.12, 0.25), n) * (1 + rng.uniform(0.02, 0.05) * rng.standard_normal(n))
    t_s = 0.3 + np.cumsum(np.maximum(0.03, steps))
    size = rng.lognormal(0, 0.15, n)
    return finished(rng, beaten(rng, t_s, size, waves.body(rng, RATE_HZ, 300, 6000, 20, (5, 40), 3e-4), t_s[-1] + 0.7))


def drum_roll(rng):
    """15 to 25 strokes a second by two hands, swelling or dying."""
    n = rng.integers(30, 80)
    steps = (1 + 0.05 * rng.standard_normal(n)) / rng.uniform(15, 25) * np.where(np.arange(n) % 2, 1.04, 0.96)
    size = np.exp(np.linspace(0, rng.uniform(-2, 2), n)) * np.where(np.arange(n) % 2, 1.0, 0.85) * rng.lognormal(0, 0.15, n)
    t_s = 0.3 + np.cumsum(steps)
    return finished(rng, beaten(rng, t_s, size, waves.body(rng, RATE_HZ, 150, 9000, 30, (4, 25), 3e-4), t_s[-1] + 0.8))


def footsteps(rng):
    """Heel and toe, some hundredths of a second apart, at a walking pace."""
    heel = 0.3 + np.cumsum(rng.uniform(0.4, 0.7) * (1 + 0.04 * rng.standard_normal(14)))
    toe = heel + rng.uniform(0.05, 0.14) * (1 + 0.15 * rng.standard_normal(14))
    struck = waves.body(rng, RATE_HZ, 80, 3000, 16, (2, 10), 2e-3)
    sound = beaten(rng, heel, rng.lognormal(0, 0.25, 14), struck, heel[-1] + 1)
    return finished(rng, sound + beaten(rng, toe, 0.5 * rng.lognormal(0, 0.3, 14), struck, heel[-1] + 1))


def formants(rng, sound):
    """Three resonances of a mouth."""
    f_hz = np.fft.rfftfreq(len(sound), 1 / RATE_HZ)
    response = 0
    for centre, width in ((rng.uniform(300, 800), 80), (rng.uniform(900, 2200), 120), (rng.uniform(2300, 3200), 200)):
        response = response + 1 / (1 + 1j * (f_hz - centre) / width)
    return np.fft.irfft(np.fft.rfft(sound) * response, len(sound))


def glottal_pulses(begin_s, pitch_hz, fall, length_s, jitter, rng):
    """Times of pulses whose pitch falls by a fraction over the length."""
    t_s, out = 0.0, []
    while t_s < length_s:
        out.append(begin_s + t_s)
        t_s += (1 + jitter * rng.standard_normal()) / (pitch_hz * (1 - fall * t_s / length_s))
    return np.array(out)


def voiced(rng, begin_s, length_s, pitch_hz, fall, duration_s):
    """One syllable: pulses through formants under an envelope."""
    sound = np.zeros(int(duration_s * RATE_HZ))
    for t in glottal_pulses(begin_s, pitch_hz, fall, length_s, 0.01, rng):
        at = t * RATE_HZ
        size = np.sin(np.pi * min(1.0, (t - begin_s + 5e-3) / (length_s + 1e-2))) ** 0.7
        waves.add(sound, size * np.array([1 - at % 1, at % 1]), int(at))
    return formants(rng, sound)


def speech(rng):
    """Syllables with falling pitch, and hisses between them."""
    duration_s, t = 6.0, 0.3
    sound = np.zeros(int(duration_s * RATE_HZ))
    pitch_hz = rng.uniform(85, 240)
    while t < duration_s - 0.6:
        length_s = rng.uniform(0.08, 0.3)
        sound += voiced(rng, t, length_s, pitch_hz * rng.uniform(0.85, 1.15), rng.uniform(0.1, 0.45), duration_s)
        if rng.random() < 0.4:
            n = int(rng.uniform(0.03, 0.12) * RATE_HZ)
            waves.add(sound, 0.05 * np.diff(rng.standard_normal(n + 1)) * np.hanning(n), int((t + length_s) * RATE_HZ))
        t += length_s + rng.exponential(0.1) + 0.02
    return finished(rng, sound)


def creak(rng):
    """A voice that ends in single pulses, 90 falling to 25 a second; or a door."""
    duration_s, length_s = 1.5, rng.uniform(0.3, 0.8)
    return finished(rng, voiced(rng, 0.2, length_s, rng.uniform(50, 90), rng.uniform(0.5, 0.75), duration_s))


def typing(rng):
    """Keys go down and come up 50 to 110 ms later, each with a sound of its own."""
    sound, t = np.zeros(int(12.0 * RATE_HZ)), 0.3
    keys = [waves.body(rng, RATE_HZ, 300, 7000, 16, (2, 8), 3e-4) for _ in range(6)]
    while t < 11.5:
        for at, size in ((t, 1.0), (t + rng.uniform(0.05, 0.11), 0.4)):
            sound += beaten(rng, [at], [size * rng.lognormal(0, 0.4)], keys[rng.integers(6)], 12.0, 0.2)
        t += 0.15 * rng.lognormal(0, 0.4) + (1.0 if rng.random() < 0.1 else 0.0)
    return finished(rng, sound)


def handling(rng):
    """Things are put down: bunches of four to eight sounds at random within three seconds, then quiet."""
    sound = np.zeros(int(20.0 * RATE_HZ))
    for begin_s in np.arange(0.4, 15.0, 5.0):
        for at in begin_s + rng.uniform(0, 3.0, rng.integers(4, 9)):
            lowest_hz = rng.uniform(80, 1500)
            thing = waves.body(rng, RATE_HZ, lowest_hz, 4 * lowest_hz, 16, (2, 15), 1e-3)
            sound += beaten(rng, [at], [rng.lognormal(0, 0.6)], thing, 20.0, 0.2)
    return finished(rng, sound)


RHYTHMS = {"metronome": metronome, "hand claps": hand_claps, "accelerando": accelerando, "drum roll": drum_roll, "footsteps": footsteps,
           "speech": speech, "creak": creak, "typing": typing, "handling": handling}
