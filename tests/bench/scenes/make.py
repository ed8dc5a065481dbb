#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings with exact truth by a generator that shares nothing with `bouncelab synthesize`, for `bouncelab validate --recordings`.

    python3 tests/bench/scenes/make.py FOLDER [--cases N] [--seed N]
    bouncelab validate --recordings FOLDER/clutter --truth FOLDER/clutter --detector builtin --out out/clutter

Makes FOLDER/few (3 to 12 impacts, eps .55 to .9, last impact 10 to 40 dB above the noise, 8 to 48 kHz), clutter (balls amid other sounds, and
balls that do what simple ones do not), drops (two balls at once, one ball at six places), no-ball (strokes, rhythms, voices) and
two-microphones: NAME.wav and NAME.truth.csv.
Each recording follows from its name and the seed. Needs python3-numpy.
"""
import argparse
import hashlib
import os
import sys

sys.dont_write_bytecode = True  # no __pycache__ in the sources

import numpy as np  # noqa: E402

import balls  # noqa: E402
import clutter  # noqa: E402
import rhythms  # noqa: E402
import sound  # noqa: E402
import strokes  # noqa: E402

IMPACTS = {"3": (3, 3), "4-5": (4, 5), "6-12": (6, 12)}
MICROPHONES = {"hard": (False, 0.3), "hard, echoes": (False, 1.0), "soft": (True, 0.5)}


def few(rng, n, snr_db, soft):
    return balls.few_bounces(rng, int(rng.integers(IMPACTS[n][0], IMPACTS[n][1] + 1)), snr_db, soft)


def without_ball(rng, make):
    rate_hz, samples = make(rng)
    return balls.Scene(rate_hz, samples, np.zeros(0), np.zeros(0, int))


def kinds():
    """(folder, kind, function of a generator of random numbers that makes a Scene)."""
    for n, snr_db, soft in [(n, s, False) for n in IMPACTS for s in (10, 20, 30, 40)] + [("6-12", s, True) for s in (10, 20, 40)]:
        yield ("few", "few %s%s impacts %d dB" % ("soft ball " if soft else "", n, snr_db),
               lambda rng, n=n, snr_db=snr_db, soft=soft: few(rng, n, snr_db, soft))
    for kind, make in clutter.CLUTTER.items():
        yield "clutter", "clutter " + kind, make
    for kind, make in clutter.DROPS.items():
        yield "drops", "drops " + kind, make
    for kind, make in {**strokes.STROKES, **rhythms.RHYTHMS}.items():
        yield "no-ball", "no ball " + kind, lambda rng, make=make: without_ball(rng, make)
    for kind, (soft, strength) in MICROPHONES.items():
        yield ("two-microphones", "stereo " + kind.replace(",", ""),
               lambda rng, soft=soft, strength=strength: balls.two_microphones(rng, strokes.RATE_HZ, soft, strength))


def rng_of(name, seed):
    return np.random.default_rng(int.from_bytes(hashlib.sha256(("%s %d" % (name, seed)).encode()).digest()[:8], "little"))


def make_all(folder, cases, seed, wanted=("few", "clutter", "drops", "no-ball", "two-microphones")):
    for place, kind, make in kinds():
        if place not in wanted:
            continue
        os.makedirs(os.path.join(folder, place), exist_ok=True)
        for name in ("%s %d" % (kind, k) for k in range(cases)):
            stem = os.path.join(folder, place, name.replace(" ", "_"))
            if not os.path.exists(stem + ".wav"):
                scene = make(rng_of(name, seed))
                sound.write_truth(stem + ".truth.csv", ("t_s", "drop"), zip(scene.t_s, scene.drop))
                sound.write(stem + ".wav", scene.rate_hz, scene.sound)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="FOLDER")
    parser.add_argument("--cases", type=int, default=12, help="recordings of each kind (%(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="(%(default)s)")
    options = parser.parse_args()
    make_all(options.folder, options.cases, options.seed)
