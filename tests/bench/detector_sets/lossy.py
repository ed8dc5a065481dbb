# SPDX-License-Identifier: GPL-3.0-or-later
"""Drops with exact truth sent through ffmpeg's encoders: are they found, and are the stated errors of intervals honest?"""
import os
import subprocess

import numpy as np

import match
from bars import Bar, by_cell, ratio, total
from onset_cases import cases_in, truth_of
from program import detect

TITLE = "codecs"
TOLERANCE_S = 3e-3
REACH_S = 60e-3  # an encoder's delay is a constant
ENCODERS = {"aac64": ("m4a", "aac", "-b:a", "64k"), "aac128": ("m4a", "aac", "-b:a", "128k"), "vorbis4": ("ogg", "libvorbis", "-q:a", "4"),
            "mp3_64": ("mp3", "libmp3lame", "-b:a", "64k"), "mp3_128": ("mp3", "libmp3lame", "-b:a", "128k"),
            "opus32": ("opus", "libopus", "-b:a", "32k"), "opus64": ("opus", "libopus", "-b:a", "64k")}


def through(encoder, recording, folder):
    """The recording encoded and decoded, as a WAV file."""
    extension, codec, option, value = ENCODERS[encoder]
    stem = os.path.join(folder, os.path.splitext(os.path.basename(recording))[0] + "_" + encoder)
    if not os.path.exists(stem + ".wav"):
        encoded = stem + "." + extension
        subprocess.run(["ffmpeg", "-v", "error", "-y", "-i", recording, "-c:a", codec, option, value, encoded], check=True)
        subprocess.run(["ffmpeg", "-v", "error", "-y", "-i", encoded, "-c:a", "pcm_s24le", stem + ".wav"], check=True)
    return stem + ".wav"


def measure(program, options):
    chosen = options.codec_cases.split(",")
    for folder in options.codecs:
        for path, recording in cases_in(folder):
            if not any(os.path.basename(path).startswith(name) for name in chosen):
                continue
            truth = truth_of(path)[0]
            for encoder in ENCODERS:
                found = detect(program, through(encoder, recording, options.work), None, options.timeout_s)
                i, j, _ = match.matched(truth, found.t_s, TOLERANCE_S, REACH_S)
                pulls = match.interval_pulls(truth, found.t_s, found.sigma_t_s, ~found.doubtful, i, j)
                yield {"file": os.path.basename(recording), "cell": encoder, "n_true": len(truth), "n_found": len(i), "n_extra": len(found.t_s) - len(i),
                       "pulls": [float(p) for p in pulls]}


def bars(records):
    out = []
    for encoder, some in by_cell(records).items():
        pulls = np.concatenate([r["pulls"] for r in some])
        n = total(some, "n_true")
        out += [Bar(encoder + ": found", ratio(total(some, "n_found"), n), least=0.98), Bar(encoder + ": clear", ratio(len(pulls), n), least=0.8),
                Bar(encoder + ": pull rms of intervals", match.rms(pulls), most=1.5), Bar(encoder + ": extra", total(some, "n_extra")),
                Bar(encoder + ": 95th percentile of the pull", float(np.percentile(np.abs(pulls), 95)) if len(pulls) else float("nan"))]
    return out


def remarks(records):
    for r in records:
        if len(r["pulls"]) and match.rms(r["pulls"]) > 1.5 or r["n_found"] < 0.98 * r["n_true"]:
            worst = sorted(np.abs(r["pulls"]))[-3:]
            yield "%s %s: %d of %d, %d clear, %d of them beyond 5 sigma, worst pulls %s" % (
                r["cell"], r["file"], r["n_found"], r["n_true"], len(r["pulls"]), np.sum(np.abs(r["pulls"]) > 5), [round(float(w), 1) for w in worst])
