# SPDX-License-Identifier: GPL-3.0-or-later
"""Speed of the whole command on one thread: processor time, the least of three runs, on generated sound at 44.1 kHz."""
import os

import numpy as np

import balls
import rhythms
import sound
import strokes
import waves
from bars import Bar
from generated import rng_of
from program import detect
from strokes import RATE_HZ

TITLE = "generated: speed, times real time"
N_RUNS = 3
LEAST = {"drops": 1400, "dense": 200}


def drops(rng):
    """Ten minutes, a ball every twelve seconds in faint noise."""
    out = 1e-3 * waves.noise(rng, 600 * RATE_HZ, RATE_HZ, 0.5)
    for begin_s in range(1, 588, 12):
        t_s, v, voice = balls.drop(rng, RATE_HZ, rng.uniform(0.75, 0.92), int(rng.integers(8, 25)))
        waves.add(out, balls.sounding(rng, t_s, v, voice, t_s[-1] + 0.8)[0], begin_s * RATE_HZ)
    return out


def dense(rng):
    """Two minutes in which everything sounds at once, as in music: strokes, rolls and voices, several in each second."""
    out = 1e-3 * waves.noise(rng, 120 * RATE_HZ, RATE_HZ, 1.0)
    makers = [strokes.drum, strokes.cymbal, strokes.jingles, rhythms.drum_roll, rhythms.speech, rhythms.accelerando]
    for k in range(300):
        waves.add(out, rng.uniform(0.05, 0.4) * makers[k % len(makers)](rng)[1], int(rng.uniform(0, 117) * RATE_HZ))
    return 0.8 * out / np.max(np.abs(out))


def measure(program, options):
    for cell, make in (("drops", drops), ("dense", dense)):
        path = os.path.join(options.work, "speed_%s.wav" % cell)
        if not os.path.exists(path):
            sound.write(path, RATE_HZ, make(rng_of("speed " + cell, options.seed)))
        runs = [detect(program, path, None, options.timeout_s) for _ in range(N_RUNS)]
        yield {"file": cell, "cell": cell, "duration_s": runs[0].duration_s, "cpu_s": min(run.cpu_s for run in runs), "n_drops": runs[0].n_drops,
               "failure": runs[0].failure}


def bars(records):
    return [Bar(r["cell"], r["duration_s"] / r["cpu_s"], least=LEAST[r["cell"]]) for r in records]


def remarks(records):
    for r in records:
        yield "%s: %d drops in %.0f s %s" % (r["cell"], r["n_drops"], r["duration_s"], r["failure"])
