# SPDX-License-Identifier: GPL-3.0-or-later
"""A generated ball and two microphones in a room: one channel's intervals against the other's, and both against the truth."""
import os

import numpy as np

import balls
import channels
import match
import sound
import waves
from bars import Bar, by_cell
from generated import rng_of
from program import detect
from strokes import RATE_HZ

TITLE = "generated: one ball, two microphones"
KINDS = {"hard": (False, 0.3), "hard, echoes": (False, 1.0), "soft": (True, 0.5)}


def two_channels(rng, soft, strength):
    """(times, samples[n, 2]): the ball bounces on one spot, so that the delay between the channels is a constant."""
    t_s, v, voice = balls.drop(rng, RATE_HZ, rng.uniform(0.75, 0.92), int(rng.integers(8, 16)), soft, shortest_s=0.05)
    out = []
    for gain in (0.5, rng.uniform(0.1, 0.5)):
        made, last = balls.sounding(rng, t_s + rng.uniform(0, 3e-3), v, voice, t_s[-1] + 0.8, room=waves.room(rng, RATE_HZ, strength))
        out.append(gain * balls.noisy(rng, made, RATE_HZ, last * 10**-rng.uniform(0.5, 1.5)))
    return t_s, np.stack(out, 1)


def measure(program, options):
    for cell, (soft, strength) in KINDS.items():
        for k in range(options.cases):
            name = "stereo %s %d" % (cell.replace(",", ""), k)
            t_s, samples = two_channels(rng_of(name, options.seed), soft, strength)
            path = os.path.join(options.work, name.replace(" ", "_") + ".wav")
            sound.write(path, RATE_HZ, samples / max(1.0, 1.1 * np.max(np.abs(samples))))
            found = [detect(program, path, channel, options.timeout_s) for channel in (0, 1)]
            true = [match.interval_pulls(t_s, f.t_s, f.sigma_t_s, np.ones(len(f.t_s), bool), *match.matched(t_s, f.t_s, 3e-3)[:2], 1.0) for f in found]
            differences, sigma, _ = channels.compared(*found)
            pulls = differences / sigma
            yield {"file": name, "cell": cell, "pulls": [float(p) for p in pulls], "true_pulls": [float(p) for p in np.concatenate(true)]}
            if not options.keep:
                os.remove(path)


def bars(records):
    out = []
    for cell, some in by_cell(records).items():
        pulls, true = (np.abs(np.concatenate([r[key] for r in some])) for key in ("pulls", "true_pulls"))
        if len(pulls) and len(true):
            out += [Bar(cell + ": median pull between channels", float(np.median(pulls)) / 0.6745, least=0.7, most=1.3),
                    Bar(cell + ": rms pull of the worst recording", max(match.rms(r["pulls"]) for r in some if r["pulls"]), most=5),
                    Bar(cell + ": median pull against the truth", float(np.median(true)) / 0.6745), Bar(cell + ": intervals", len(pulls))]
    return out


def remarks(records):
    for r in records:
        if match.rms(r["pulls"]) > 5 or match.rms(r["true_pulls"]) > 5:
            yield "%s: %d intervals, pull rms between channels %.1f, against the truth %.1f" % (
                r["file"], len(r["pulls"]), match.rms(r["pulls"]), match.rms(r["true_pulls"]))
