# SPDX-License-Identifier: GPL-3.0-or-later
"""Drops of generated balls: times, and sound with its truth. Flight times fall by eps, whose scatter is normal or Laplace."""
import dataclasses

import numpy as np

import waves

GRAVITY_MPS2 = 9.81


@dataclasses.dataclass
class Scene:
    """A recording that is being made: sound, and the impacts of its balls."""
    rate_hz: int
    sound: np.ndarray
    t_s: np.ndarray
    drop: np.ndarray


def scattered_eps(rng, eps, scatter, n):
    draw = rng.standard_normal(n) if rng.random() < 0.5 else rng.laplace(0, np.sqrt(0.5), n)
    return np.clip(eps + scatter * draw, 0.3, 0.995)


def bounce_times(first_s, flight_s, eps):
    """Times of len(eps) + 2 impacts: first flight given, each next one eps times the last."""
    return first_s + np.concatenate([[0], np.cumsum(flight_s * np.concatenate([[1], np.cumprod(eps)]))])


def speeds(t_s, eps_first):
    """Speed of each impact: of the first from eps_first, of the others from the flight before."""
    flights = np.diff(t_s)
    return 0.5 * GRAVITY_MPS2 * np.concatenate([[flights[0] / eps_first], flights])


def loudness(rng, speed_mps, exponent, scatter):
    relative = (speed_mps / speed_mps[0]) ** exponent
    return relative * np.exp(scatter * rng.standard_normal(len(speed_mps)))


def drop(rng, rate_hz, eps, n_impacts, soft=False, first_s=None, shortest_s=0.02):
    """(times, speeds, voice): a ball whose last interval is not below the shortest; eps is raised where it would be."""
    flight_s = rng.uniform(0.25, 0.6)
    eps = max(eps, (shortest_s / flight_s) ** (1 / max(1, n_impacts - 2)))
    values = scattered_eps(rng, eps, rng.uniform(0.002, 0.02), n_impacts - 2)
    t_s = bounce_times(rng.uniform(0.3, 1.0) if first_s is None else first_s, flight_s, values)
    voice = waves.Voice((waves.soft_ball if soft else waves.hard_ball)(rng, rate_hz), rng.uniform(0.05, 0.4))
    return t_s, speeds(t_s, eps), voice


def sounding(rng, t_s, speed_mps, voice, duration_s, exponent=None, room=None):
    """Sound of a drop in its room (a response), loudest impact about 0.5; and the peak of its last impact."""
    exponent = rng.uniform(0.9, 1.4) if exponent is None else exponent
    sound, peaks = waves.struck_at(voice, t_s, speed_mps, loudness(rng, speed_mps, exponent, rng.uniform(0.03, 0.25)), duration_s, rng)
    response = waves.room(rng, voice.struck.rate_hz, rng.choice([0, 0.3, 0.8])) if room is None else room
    scale = 0.5 / np.max(peaks)
    return scale * waves.convolved(sound, response), scale * peaks[-1]


def noisy(rng, sound, rate_hz, level):
    """With coloured noise of the given rms."""
    return sound + level * waves.noise(rng, len(sound), rate_hz, rng.choice([0, 0.5, 1.0]), rng.choice([0, 0.5]))


def few_bounces(rng, n_impacts, snr_db, soft=False):
    """A drop of a few impacts; snr_db = peak of the last over the rms of the noise."""
    rate_hz = int(rng.choice([8000, 16000, 22050, 44100, 48000]))
    t_s, v, voice = drop(rng, rate_hz, rng.uniform(0.55, 0.9), n_impacts, soft, shortest_s=0.05 if soft else 0.02)
    duration_s = t_s[-1] + rng.uniform(0.5, 1.2)
    sound, last_peak = sounding(rng, t_s, v, voice, duration_s)
    sound = noisy(rng, sound, rate_hz, last_peak * 10**(-snr_db / 20))
    sound *= min(1, 0.9 / np.max(np.abs(sound)))
    return Scene(rate_hz, sound, t_s, np.zeros(len(t_s), int))


def two_microphones(rng, rate_hz, soft, strength):
    """Two channels; the ball bounces on one spot, so that the delay between them is a constant. True times are those of the impacts."""
    t_s, v, voice = drop(rng, rate_hz, rng.uniform(0.75, 0.92), int(rng.integers(8, 16)), soft, shortest_s=0.05)
    out = []
    for gain in (0.5, rng.uniform(0.1, 0.5)):
        made, last = sounding(rng, t_s + rng.uniform(0, 3e-3), v, voice, t_s[-1] + 0.8, room=waves.room(rng, rate_hz, strength))
        out.append(gain * noisy(rng, made, rate_hz, last * 10**-rng.uniform(0.5, 1.5)))
    both = np.stack(out, 1)
    return Scene(rate_hz, both / max(1.0, 1.1 * np.max(np.abs(both))), t_s, np.zeros(len(t_s), int))
