# SPDX-License-Identifier: GPL-3.0-or-later
"""Generated sets: drops of a few bounces, sounds without a ball, balls in clutter. A case has a name; its sound follows from that and the seed."""
import hashlib
import os

import numpy as np

import balls
import clutter
import match
import rhythms
import sound
import strokes
from bars import Bar, by_cell, ratio, total
from program import detect

TOLERANCE_S = 3e-3
IMPACTS = {"3": (3, 3), "4-5": (4, 5), "6-12": (6, 12)}
SNR_DB = (0, 10, 20, 30, 40)


def rng_of(name, seed):
    return np.random.default_rng(int.from_bytes(hashlib.sha256(("%s %d" % (name, seed)).encode()).digest()[:8], "little"))


def detected_in(program, name, rate_hz, samples, options):
    path = os.path.join(options.work, name.replace(" ", "_") + ".wav")
    sound.write(path, rate_hz, samples)
    found = detect(program, path, None, options.timeout_s)
    if not options.keep:
        os.remove(path)
    return found


def ball_record(program, name, cell, scene, options):
    found = detected_in(program, name, scene.rate_hz, scene.sound, options)
    if options.keep:
        with open(os.path.join(options.work, name.replace(" ", "_") + ".truth.csv"), "w") as file:
            file.write("t_s\n" + "".join("%.6f\n" % t for t in scene.t_s))
    i, j, offset = match.matched(scene.t_s, found.t_s, TOLERANCE_S)
    clear = match.interval_pulls(scene.t_s, found.t_s, found.sigma_t_s, ~found.doubtful, i, j)
    missed = [k for k in range(len(scene.t_s)) if k not in set(i)]
    extra = [round(float(found.t_s[k] - offset), 4) for k in range(len(found.t_s)) if k not in set(j)]
    return {"file": name, "cell": cell, "n_true": len(scene.t_s), "n_found": len(i), "n_all": len(found.t_s), "n_drops": found.n_drops,
            "n_true_drops": len(set(scene.drop)), "missed": missed, "extra_s": extra, "pulls": [float(p) for p in clear], "failure": found.failure}


def ball_bars(records, judged):
    """Of each cell: recall, precision, drops as they were; over all: the pull of the intervals that are stated to be clear."""
    out = []
    for cell, some in by_cell(records).items():
        least = (0.95, 0.98, 0.95) if judged(cell) else (None, None, None)
        out += [Bar(cell + ": recall", ratio(total(some, "n_found"), total(some, "n_true")), least=least[0]),
                Bar(cell + ": precision", ratio(total(some, "n_found"), total(some, "n_all")), least=least[1]),
                Bar(cell + ": right number of drops", ratio(sum(r["n_drops"] == r["n_true_drops"] for r in some), len(some)), least=least[2])]
    some = [r for r in records if judged(r["cell"])]
    pulls = np.abs(np.concatenate([r["pulls"] for r in some])) if some else np.zeros(0)
    return [Bar("recall", ratio(total(some, "n_found"), total(some, "n_true")), least=0.95),
            Bar("precision", ratio(total(some, "n_found"), total(some, "n_all")), least=0.98),
            Bar("clear intervals", ratio(len(pulls), total(some, "n_true"))),
            Bar("median pull of clear intervals", float(np.median(pulls)) / 0.6745 if len(pulls) else np.nan),
            Bar("clear intervals beyond 5 sigma", ratio(int(np.sum(pulls > 5)), len(pulls)), most=0.005)] + out


def ball_remarks(records):
    for r in records:
        if r["missed"] or r["extra_s"] or r["failure"] or r["n_drops"] != r["n_true_drops"]:
            yield "%s: %d of %d, missed impacts %s, extra at %s s, %d drops for %d %s" % (
                r["file"], r["n_found"], r["n_true"], r["missed"], r["extra_s"], r["n_drops"], r["n_true_drops"], r["failure"])


class FewBounces:
    TITLE = "generated: few bounces (eps .55 to .9, 8 to 48 kHz)"

    @staticmethod
    def measure(program, options):
        kinds = [(n, snr, False) for n in IMPACTS for snr in SNR_DB] + [("6-12", snr, True) for snr in (10, 20, 40)]
        for n, snr_db, soft in kinds:
            cell = "%s%s impacts, %d dB" % ("soft ball, " if soft else "", n, snr_db)
            for k in range(options.cases):
                name = "few %s %d" % (cell.replace(",", ""), k)
                rng = rng_of(name, options.seed)
                scene = balls.few_bounces(rng, int(rng.integers(IMPACTS[n][0], IMPACTS[n][1] + 1)), snr_db, soft)
                yield ball_record(program, name, cell, scene, options)

    @staticmethod
    def bars(records):
        return ball_bars(records, lambda cell: not cell.endswith(" 0 dB"))

    remarks = staticmethod(ball_remarks)


class Clutter:
    TITLE = "generated: balls in clutter"

    @staticmethod
    def measure(program, options):
        for cell, make in clutter.CLUTTER.items():
            for k in range(options.cases):
                name = "clutter %s %d" % (cell, k)
                yield ball_record(program, name, cell, make(rng_of(name, options.seed)), options)

    @staticmethod
    def bars(records):
        return ball_bars(records, lambda cell: True)

    remarks = staticmethod(ball_remarks)


class NoBall:
    TITLE = "generated: no ball (strokes and their decays, rhythms, voices)"

    @staticmethod
    def measure(program, options):
        for cell, make in {**strokes.STROKES, **rhythms.RHYTHMS}.items():
            for k in range(options.cases):
                name = "no ball %s %d" % (cell, k)
                rate_hz, samples = make(rng_of(name, options.seed))
                found = detected_in(program, name, rate_hz, samples, options)
                yield {"file": name, "cell": cell, "n_drops": found.n_drops, "impacts": [int(np.sum(found.drop == d)) for d in sorted(set(found.drop))],
                       "duration_s": found.duration_s, "cpu_s": found.cpu_s, "failure": found.failure}

    @staticmethod
    def bars(records):
        out = [Bar("invented", total(records, "n_drops"), most=0), Bar("recordings", len(records)),
               Bar("x real time", ratio(total(records, "duration_s"), total(records, "cpu_s")))]
        return out + [Bar(cell, total(some, "n_drops"), most=0) for cell, some in by_cell(records).items()]

    @staticmethod
    def remarks(records):
        for r in records:
            if r["n_drops"] or r["failure"]:
                yield "%s: drops of %s impacts %s" % (r["file"], r["impacts"], r["failure"])
