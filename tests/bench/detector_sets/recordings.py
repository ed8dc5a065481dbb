# SPDX-License-Identifier: GPL-3.0-or-later
"""Annotated recordings of real balls: NAME.wav with NAME.truth.csv (header t_s); and the same sound cut, delayed and by channels."""
import csv
import glob
import os

import numpy as np

import match
import sound
from bars import Bar, ratio, total
from program import detect

TOLERANCE_S = 3e-3  # what an annotator can tell
TITLE = "annotated recordings"


def annotated(folder):
    for path in sorted(glob.glob(os.path.join(folder, "*.truth.csv"))):
        recording = path[:-len(".truth.csv")] + ".wav"
        if os.path.exists(recording):
            with open(path, newline="") as file:
                yield recording, np.sort([float(row["t_s"]) for row in csv.DictReader(file)])


def scored(truth, found):
    """Counts up to the last annotated impact, after which the annotation says nothing."""
    i, j, offset = match.matched(truth, found.t_s, TOLERANCE_S)
    inside = (found.t_s - offset > truth[0] - 5e-3) & (found.t_s - offset < truth[-1] + TOLERANCE_S)
    extra = [round(float(t), 4) for k, t in enumerate(found.t_s) if inside[k] and k not in set(j)]
    missed = [round(float(t), 4) for k, t in enumerate(truth) if k not in set(i)]
    return {"n_true": len(truth), "n_found": len(i), "n_inside": len(i) + len(extra), "n_before": int(np.sum(found.t_s - offset < truth[0] - 5e-3)),
            "n_drops": found.n_drops, "n_drops_of_impacts": len(set(found.drop[j])), "missed_s": missed, "extra_s": extra}


def quiet_before(samples, rate_hz, rng):
    """A second of noise with the spectrum of the quietest tenth of a second."""
    n = int(0.1 * rate_hz)
    starts = range(0, max(1, len(samples) - n), n // 2)
    quietest = samples[min(starts, key=lambda k: np.sum(samples[k:k + n]**2)):][:n]
    length = int(rate_hz)
    frequency = np.fft.rfftfreq(length)
    columns = []
    for column in (quietest - quietest.mean(0)).T:
        magnitude = np.abs(np.fft.rfft(column * np.hanning(n)))
        spectrum = np.interp(frequency, np.fft.rfftfreq(n), magnitude) * np.exp(2j * np.pi * rng.random(len(frequency)))
        noise = np.fft.irfft(spectrum, length)
        columns.append(noise * column.std() / max(noise.std(), 1e-12))
    return np.stack(columns, 1)


def variants(recording, folder):
    """(name, file, channel, begin_s, moved_s): true times after begin, moved, are those of the variant."""
    rate_hz, samples = sound.read(recording)
    stem = os.path.join(folder, os.path.splitext(os.path.basename(recording))[0])
    middle = len(samples) // 2
    sound.write(stem + "_cut.wav", rate_hz, samples[middle:])
    sound.write(stem + "_before.wav", rate_hz, np.concatenate([quiet_before(samples, rate_hz, np.random.default_rng(1)), samples]))
    yield "from the middle", stem + "_cut.wav", None, middle / rate_hz, -middle / rate_hz
    yield "a second more before", stem + "_before.wav", None, 0.0, 1.0
    if samples.shape[1] > 1:
        for channel in range(samples.shape[1]):
            yield "channel %d alone" % channel, recording, channel, 0.0, 0.0
    else:
        faint = 0.5 * samples + 0.5 * np.std(samples[:rate_hz // 50]) * np.random.default_rng(2).standard_normal(samples.shape)
        sound.write(stem + "_stereo.wav", rate_hz, np.concatenate([faint, samples], 1))
        yield "with a fainter channel", stem + "_stereo.wav", None, 0.0, 0.0


def alike(program, recording, whole, truth, options):
    """Of each variant: impacts in both, over those in either, from the first annotated impact that both hold."""
    out = {}
    for name, path, channel, begin_s, moved_s in variants(recording, options.work):
        found = detect(program, path, channel, options.timeout_s)
        first = max(begin_s + 5e-3, truth[0] - 5e-3)
        here, there = [t[(t > first) & (t < truth[-1] + TOLERANCE_S)] for t in (whole.t_s, found.t_s - moved_s)]
        both = len(match.pairs(here, there, TOLERANCE_S)[0])
        out[name] = {"n_both": both, "n_either": len(here) + len(there) - both}
    return out


def measure(program, options):
    for folder in options.recordings:
        for recording, truth in annotated(folder):
            whole = detect(program, recording, None, options.timeout_s)
            yield {"file": os.path.basename(recording), "failure": whole.failure, "duration_s": whole.duration_s, "cpu_s": whole.cpu_s,
                   **scored(truth, whole), "variants": alike(program, recording, whole, truth, options)}


def bars(records):
    n_true = total(records, "n_true")
    found = total(records, "n_found")
    out = [Bar("recall", ratio(found, n_true), least=0.985), Bar("precision", ratio(found, total(records, "n_inside")), least=0.985),
           Bar("recall of the worst file", min(r["n_found"] / r["n_true"] for r in records), least=0.93),
           Bar("impacts found before the first", total(records, "n_before")),
           Bar("files whose impacts are one drop", ratio(sum(r["n_drops_of_impacts"] == 1 for r in records), len(records)), least=1),
           Bar("drops found a file", ratio(total(records, "n_drops"), len(records)))]
    for name in sorted({name for r in records for name in r["variants"]}):
        some = [r["variants"][name] for r in records if name in r["variants"]]
        out.append(Bar("same impacts: " + name, ratio(total(some, "n_both"), total(some, "n_either")), least=1))
    return out + [Bar("x real time", ratio(total(records, "duration_s"), total(records, "cpu_s")))]


def remarks(records):
    for r in records:
        changed = ["%s %d/%d" % (name, v["n_both"], v["n_either"]) for name, v in r["variants"].items() if v["n_both"] < v["n_either"]]
        if r["missed_s"] or r["extra_s"] or changed or r["failure"] or r["n_drops_of_impacts"] != 1:
            yield "%s: %d of %d in %d drops, missed %s, extra %s %s %s" % (
                r["file"], r["n_found"], r["n_true"], r["n_drops_of_impacts"], r["missed_s"], r["extra_s"], "; ".join(changed), r["failure"])
