# SPDX-License-Identifier: GPL-3.0-or-later
"""Balls in what surrounds them, and balls that do what simple ones do not. Each function makes one Scene with its truth."""
import dataclasses

import numpy as np

import balls
import rhythms
import waves
from balls import Scene
from strokes import RATE_HZ


def plain(rng, n=None, eps=None, soft=False, tail_s=0.8, **how):
    """A drop at 44.1 kHz with its sound: (times, speeds, voice, sound, peak of the last impact)."""
    t_s, v, voice = balls.drop(rng, RATE_HZ, rng.uniform(0.7, 0.92) if eps is None else eps, rng.integers(7, 16) if n is None else n, soft, **how)
    sound, last = balls.sounding(rng, t_s, v, voice, t_s[-1] + tail_s)
    return t_s, v, voice, sound, last


def scene(rng, t_s, sound, level, drop=None):
    sound = balls.noisy(rng, sound, RATE_HZ, level)
    sound *= min(1, 0.9 / np.max(np.abs(sound)))
    return Scene(RATE_HZ, sound, np.asarray(t_s), np.zeros(len(t_s), int) if drop is None else drop)


def remade(rng, t_s, voice, eps_first, gain=None):
    """A drop whose times were changed, in a quiet room; gain multiplies the loudness of each impact."""
    v = balls.speeds(t_s, eps_first)
    size = balls.loudness(rng, v, 1.2, 0.1) * (1 if gain is None else gain)
    sound, peaks = waves.struck_at(voice, t_s, v, size, t_s[-1] + 0.8, rng)
    sound = waves.convolved(sound, waves.room(rng, RATE_HZ, 0.3))
    return 0.5 * sound / np.max(peaks), 0.5 * peaks[-1] / np.max(peaks)


def over(rng, other):
    """A drop with another sound, six to twenty times fainter at its peak, over all of it."""
    t_s, _, _, sound, last = plain(rng)
    _, speech = other(rng)
    speech = np.resize(speech, len(sound))
    return scene(rng, t_s, sound + 0.5 * rng.uniform(0.05, 0.16) * speech / np.max(np.abs(speech)), 0.03 * last)


def over_speech(rng):
    return over(rng, rhythms.speech)


def over_claps(rng):
    return over(rng, rhythms.hand_claps)


def over_metronome(rng):
    return over(rng, rhythms.metronome)


def after_speech(rng):
    """Somebody speaks as loud as the ball, stops, and drops it."""
    first_s = rng.uniform(5.8, 6.3)
    t_s, _, _, sound, last = plain(rng, first_s=first_s)
    _, speech = rhythms.speech(rng)
    waves.add(sound, 0.4 * speech / np.max(np.abs(speech)), -int(0.3 * RATE_HZ))
    return scene(rng, t_s, sound, 0.03 * last)


def two_balls(rng):
    """One after the other, the same ball or another."""
    t_s, v, voice, sound, last = plain(rng)
    other = voice if rng.random() < 0.5 else waves.Voice(waves.hard_ball(rng, RATE_HZ), 0.2)
    again, v2, _ = balls.drop(rng, RATE_HZ, rng.uniform(0.7, 0.92), rng.integers(7, 16), first_s=t_s[-1] + rng.uniform(0.5, 1.5))
    sound2, last2 = balls.sounding(rng, again, v2, other, again[-1] + 0.8)
    waves.add(sound2, sound, 0)
    return scene(rng, np.concatenate([t_s, again]), sound2, 0.05 * min(last, last2), np.repeat([0, 1], [len(t_s), len(again)]))


def hits_something(rng):
    """A knock on another body in flight k, which changes that flight and, by another factor, all after it."""
    t_s, _, voice, _, _ = plain(rng, n=rng.integers(9, 16), shortest_s=0.04)
    k = rng.integers(2, len(t_s) - 4)
    flights = np.diff(t_s)
    flights[k] *= rng.uniform(0.6, 1.0)
    flights[k + 1:] *= rng.uniform(0.6, 1.05)
    t_s = t_s[0] + np.concatenate([[0], np.cumsum(flights)])
    knock_s = t_s[k] + rng.uniform(0.3, 0.6) * flights[k]
    sound, last = remade(rng, t_s, voice, 0.8)
    wood = waves.Voice(waves.body(rng, RATE_HZ, 200, 3000, 20, (5, 30), 5e-4), 0.1)
    waves.add(sound, waves.struck_at(wood, [knock_s], [1.0], [rng.uniform(0.1, 0.4)], len(sound) / RATE_HZ, rng)[0], 0)
    return scene(rng, t_s, sound, 0.05 * last)


def jumping_eps(rng):
    """Eps .72 at the first impacts, .81 later; often one interval longer than the one before."""
    n = rng.integers(6, 12)
    eps = np.where(np.arange(n - 2) < rng.integers(1, 3), rng.uniform(0.68, 0.74), rng.uniform(0.79, 0.84)) + 0.004 * rng.standard_normal(n - 2)
    if rng.random() < 0.4:
        eps[rng.integers(0, len(eps))] = rng.uniform(1.0, 1.06)
    t_s = balls.bounce_times(0.6, rng.uniform(0.4, 0.6), eps)
    sound, last = remade(rng, t_s, waves.Voice(waves.hard_ball(rng, RATE_HZ), 0.2), 0.72)
    return scene(rng, t_s, sound, 0.05 * last)


def first_flight(rng):
    """Eps .5 to .58 at the second impact, then .7 to .85."""
    n = rng.integers(6, 12)
    eps = np.concatenate([[rng.uniform(0.5, 0.58)], rng.uniform(0.7, 0.85) + 0.01 * rng.standard_normal(n - 3)])
    t_s = balls.bounce_times(0.6, rng.uniform(0.5, 0.8), eps)
    sound, last = remade(rng, t_s, waves.Voice(waves.hard_ball(rng, RATE_HZ), 0.2), 0.53)
    return scene(rng, t_s, sound, 0.05 * last)


def before_each(rng, precursor):
    """Something 5 to 30 ms before each impact, at a delay that scatters a little, a twentieth to a third of its size."""
    t_s, v, _, sound, last = plain(rng, shortest_s=0.06)
    lead_s, strength = rng.uniform(5e-3, 30e-3), rng.uniform(0.05, 0.3)
    for t, size in zip(t_s, (v / v[0]) ** 1.2):
        wave = precursor(rng, lead_s)
        waves.add(sound, 0.5 * strength * size * wave, int((t - lead_s * rng.uniform(0.9, 1.1)) * RATE_HZ))
    return scene(rng, t_s, sound, 0.05 * last)


def soft_ramp(rng):
    """A rumble that swells until the impact."""
    def ramp(generator, lead_s):
        n = int(lead_s * RATE_HZ)
        return np.linspace(0, 1, n) ** 2 * waves.noise(generator, n, RATE_HZ, 2.0) * 0.4
    return before_each(rng, ramp)


def click_before(rng):
    """A click, as of something loose."""
    def click(generator, _):
        return generator.standard_normal(40) * np.exp(-np.arange(40) / 8) * 0.7
    return before_each(rng, click)


def dense_end(rng):
    """A bouncy ball until its intervals are 8 to 12 ms, with an echo of about the same delay."""
    eps, flight_s, last_s = rng.uniform(0.8, 0.92), rng.uniform(0.15, 0.3), rng.uniform(8e-3, 12e-3)
    n = int(np.log(last_s / flight_s) / np.log(eps)) + 2
    t_s = balls.bounce_times(0.5, flight_s, balls.scattered_eps(rng, eps, 0.005, n - 2))
    voice = waves.Voice(waves.body(rng, RATE_HZ, 1500, 18e3, 30, (8, 40), 5e-5), 0.2)
    sound, last = remade(rng, t_s, voice, eps)
    response = np.zeros(int(0.02 * RATE_HZ))
    response[0], response[int(rng.uniform(7e-3, 15e-3) * RATE_HZ)] = 1, rng.uniform(0.1, 0.35)
    return scene(rng, t_s, waves.convolved(sound, response), 0.03 * last)


def gain_control(rng):
    """A recorder that makes everything equally loud: amplitudes do not decay, noise swells between impacts."""
    t_s, _, _, sound, last = plain(rng, n=rng.integers(10, 20))
    sound = balls.noisy(rng, sound, RATE_HZ, 0.03 * last)
    window = int(0.2 * RATE_HZ)
    level = np.sqrt(np.maximum.accumulate(np.full(1, 1e-9)) + waves.convolved(sound**2, np.ones(window) / window).clip(0))
    sound = sound * (0.1 / np.maximum(level, 0.003)).clip(0, 30)
    return Scene(RATE_HZ, 0.8 * sound / np.max(np.abs(sound)), t_s, np.zeros(len(t_s), int))


def clipped(rng):
    """First impacts five to twenty times too loud for the recorder."""
    t_s, _, _, sound, last = plain(rng, n=rng.integers(8, 16))
    made = scene(rng, t_s, sound, 0.03 * last)
    made.sound = np.clip(made.sound * rng.uniform(5, 20), -0.99, 0.99)
    return made


def soft_ball(rng):
    """A dull ball in a room."""
    t_s, _, _, sound, last = plain(rng, soft=True, shortest_s=0.06)
    return scene(rng, t_s, sound, 0.03 * last)


def at_once(rng):
    """Two balls that bounce at the same time, of one kind or of two."""
    t_s, v, voice, sound, last = plain(rng, n=rng.integers(8, 16))
    other = voice if rng.random() < 0.5 else waves.Voice(waves.hard_ball(rng, RATE_HZ), 0.2)
    second, v2, _ = balls.drop(rng, RATE_HZ, rng.uniform(0.7, 0.92), rng.integers(8, 16), first_s=t_s[0] + rng.uniform(0.1, 0.6))
    sound2, last2 = balls.sounding(rng, second, v2, other, max(t_s[-1], second[-1]) + 0.8)
    waves.add(sound2, sound, 0)
    return scene(rng, np.concatenate([t_s, second]), sound2, 0.05 * min(last, last2), np.repeat([0, 1], [len(t_s), len(second)]))


def many_drops(rng):
    """A ball dropped six times, each time at another place, where the plate's modes sound with other amplitudes of either sign."""
    plate, times, sound, least = waves.hard_ball(rng, RATE_HZ), [], np.zeros(0), np.inf
    for _ in range(6):
        struck = dataclasses.replace(plate, amplitude=rng.standard_normal(len(plate.f_hz)))
        first_s = times[-1][-1] + rng.uniform(0.5, 1.5) if times else 0.5
        t_s, v, _ = balls.drop(rng, RATE_HZ, rng.uniform(0.7, 0.92), rng.integers(8, 20), first_s=first_s)
        more, last = balls.sounding(rng, t_s, v, waves.Voice(struck, 0.1), t_s[-1] + 0.8)
        waves.add(more, sound, 0)
        times, sound, least = times + [t_s], more, min(least, last)
    return scene(rng, np.concatenate(times), sound, 0.05 * least, np.repeat(np.arange(6), [len(t) for t in times]))


CLUTTER = {"over speech": over_speech, "over hand claps": over_claps, "over a metronome": over_metronome, "after speech": after_speech,
           "two balls": two_balls, "hits something": hits_something, "eps jumps": jumping_eps, "first flight of eps .53": first_flight,
           "soft ramp before": soft_ramp, "click before": click_before, "10 ms apart at the end": dense_end, "gain control": gain_control,
           "clipped": clipped, "soft ball": soft_ball}

DROPS = {"two balls at once": at_once, "one ball at six places": many_drops}
