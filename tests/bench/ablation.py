#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What each part of the detector is worth: the sets of recordings with it and without it, as the table of docs/detector.md.

    tools/build detect_with
    python3 tests/bench/ablation.py [--only PART ...] [--pairs] [--recordings DIR ...] [--channels DIR ...] [--onset-cases DIR] [--no-ball DIR]

A part is taken out by one number of the models (acoustic/detection/src/*/*_model.hpp), at which it does nothing. --pairs takes out every two
of the parts named. Each line has recall / precision on each folder of annotated recordings (NAME.wav, NAME.truth.csv with t_s and,
where annotations are uncertain by more than a millisecond, u_s), on generated drops of few bounces and in clutter, and through codecs; the log score of
the stated errors of intervals, -ln sigma - e^2 / (2 sigma^2) in nats with sigma in us (a pull beyond 5 counts as 5), against the truth, through codecs and
between two channels; balls invented; processor time over that of the whole. --part build decides, --part held-out reports: halves of
every set by a hash of the file's name. Needs python3-numpy and ffmpeg.
"""
import argparse
import csv
import glob
import itertools
import os
import sys
import tempfile

sys.dont_write_bytecode = True
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "detector_sets"))

import numpy as np  # noqa: E402

import balls  # noqa: E402
import channels  # noqa: E402
import clutter  # noqa: E402
import generated  # noqa: E402
import lossy  # noqa: E402
import match  # noqa: E402
import no_ball  # noqa: E402
import onset_cases  # noqa: E402
import sound  # noqa: E402
from program import detect  # noqa: E402

PROGRAM = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../build/release/tests/bench/detect_with")
NEVER = 1e9
# the part, and the numbers with which it does nothing
PARTS = {
    "faint sounds before louder ones": {"kCandidates.faint": 0},
    "band energies": {"kCandidates.independence": 0},
    "rhythms": {"kTracking.rhythm_log_odds": -100},
    "single losses and gains": {"kTracking.outliers": 1e-9},
    "loss of energy": {"kTracking.least_loss": -10},
    "unexplained sounds": {"kTracking.unexplained": 0},
    "echoes no clutter": {"kTracking.echo_s": 0},
    "first impact anew": {"kTracking.known_after": NEVER},
    "power of the loudness": {"kTracking.loudness_exponent": 1, "kTracking.exponent_scatter": 0},
    "lower bands": {"kTracking.lower_band": NEVER},
    "lower bands only where unclear": {"kChannels.explained": 2},
    "long template": {"kTemplate.many_close": NEVER},
    "several beginnings": {"kTemplate.most_starts": 1},
    "windows at attacks": {"kTemplate.attack_share": 0},
    "0.01 not repeated": {"kTemplate.unrepeated": 0},
    "whitening by residuals": {"kTemplate.residual_order": 0},
    "coherence weight": {"kTemplate.fewest_for_coherence": NEVER},
    "weak bands merged": {"kTemplate.least_information_share": 0},
    "amplitudes of sub-bands": {"kTemplate.amplitude_prior": NEVER},
    "jitter of one band": {"kTemplate.fewest_subbands": 0},
    "jitter shrunk": {"kTemplate.prior_impacts": 0},
    "chi2 of the bands": {"kTemplate.prior_subbands": NEVER},
    "gaps": {"kDelay.least_in_gap": NEVER},
    "beyond the end": {"kDelay.least_of_outlier": NEVER},
    "far places": {"kDelay.much_left": NEVER},
    "predicted places": {"kDelay.unexpected": NEVER},
    "forward-backward": {"kDelay.fewest_impacts": NEVER},
    "own template of a drop": {"kDrops.own_template": NEVER},
    "timed in the whole sound": {"kDrops.clearly_less": 0},
    "other bands": {"kDrops.fewest_shared": NEVER},
    "contact time fitted": {"kContact.fewest_impacts": NEVER},
    "contact time": {"kContact.fewest_impacts": NEVER, "kContact.duration_times_frequency": 0},
}


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=list(PARTS), default=list(PARTS), metavar="PART")
    parser.add_argument("--pairs", action="store_true", help="every two of the parts together")
    parser.add_argument("--part", choices=("build", "held out"), help="one half of every set")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="a line with other numbers, in place of the parts")
    parser.add_argument("--program", default=PROGRAM)
    parser.add_argument("--hours", type=float, default=1.0, help="of sound without a ball (%(default)s)")
    parser.add_argument("--cases", type=int, default=8, help="generated recordings of each kind (%(default)s)")
    parser.add_argument("--work", metavar="DIR", help="keep encoded and generated sounds here, and take them from here again")
    for name in ("recordings", "channels", "onset-cases", "no-ball"):
        parser.add_argument("--" + name, action="append", default=[], metavar="DIR")
    options = parser.parse_args()
    options.codec_cases, options.seed, options.piece_s = "c03,c05,c06,c11".split(","), 1, 60
    return options


class Counts:
    """Impacts that are true, found and marked, errors and stated errors of intervals, and what it took."""

    def __init__(self):
        self.counts, self.errors, self.invented, self.cpu_s = {}, {}, 0, 0.0

    def add_impacts(self, column, n_true, n_found, n_marked):
        self.counts.setdefault(column, np.zeros(3))
        self.counts[column] += (n_true, n_found, n_marked)

    def add_errors(self, column, error_s, sigma_s):
        self.errors.setdefault(column, []).extend(zip(error_s, sigma_s))

    def cells(self):
        out = ["%.3f / %.3f" % (n[1] / n[0], n[1] / max(1, n[2])) for n in self.counts.values()]
        for pairs in self.errors.values():
            error, sigma = np.array(pairs).T
            score = np.mean(-0.5 * np.minimum((error / sigma)**2, 25) - np.log(1e6 * sigma))
            out.append("%.2f (%.2f)" % (score, np.median(np.abs(error / sigma)) / 0.6745))
        return out + ["%d" % self.invented]


def intervals(truth, found, i, j):
    """Errors of the intervals between impacts that follow each other, and their stated errors."""
    if len(i) < 2:
        return [], []
    error, sigma = np.diff(found.t_s[j] - truth[i]), np.hypot(found.sigma_t_s[j][1:], found.sigma_t_s[j][:-1])
    use = (np.diff(i) == 1) & (np.diff(truth[i]) < 0.5) & np.isfinite(sigma)
    return error[use], sigma[use]


def annotated(folder):
    for path in sorted(glob.glob(os.path.join(folder, "*.truth.csv"))):
        with open(path, newline="") as file:
            rows = sorted((float(row["t_s"]), float(row.get("u_s") or 1e-3)) for row in csv.DictReader(file))
        yield path[:-len(".truth.csv")] + ".wav", np.array(rows)


def score_recording(found, truth):
    """Impacts within the annotation's uncertainty; marks up to the last annotated impact."""
    t, tolerance = truth[:, 0], np.maximum(3e-3, 2 * truth[:, 1])
    _, _, offset = match.matched(t, found.t_s, 3e-3)
    marks = found.t_s - offset
    i, j = match.pairs(t, marks, tolerance.max())
    right = np.abs(marks[j] - t[i]) < tolerance[i]
    inside = (marks > t[0] - 5e-3) & (marks < t[-1] + 3e-3)
    return len(t), int(right.sum()), int(inside.sum())


def generated_scenes(options):
    for n, snr, soft in [(n, snr, False) for n in generated.IMPACTS for snr in (10, 20, 30, 40)] + [("6-12", snr, True) for snr in (10, 20, 40)]:
        for k in range(options.cases):
            name = "few %s%s impacts %d dB %d" % ("soft ball " if soft else "", n, snr, k)
            few, most = generated.IMPACTS[n]

            def make(rng, few=few, most=most, snr=snr, soft=soft):
                return balls.few_bounces(rng, int(rng.integers(few, most + 1)), snr, soft)
            yield "few bounces", name, make
    for cell, make in clutter.CLUTTER.items():
        for k in range(options.cases):
            yield "clutter", "clutter %s %d" % (cell, k), make


class Sets:
    """All that is there, made once."""

    def __init__(self, options):
        self.options, self.scenes = options, []
        for column, name, make in generated_scenes(options):
            scene, path = make(generated.rng_of(name, 1)), os.path.join(options.work, name.replace(" ", "_") + ".wav")
            if not os.path.exists(path):
                sound.write(path, scene.rate_hz, scene.sound)
            self.scenes.append((column, path, scene.t_s))
        self.no_ball = [(path, piece) for _, path, piece in no_ball.sampled(options)]

    def is_used(self, path):
        return not self.options.part or sound.part_of(os.path.basename(path)) == self.options.part

    def score(self, settings):
        command = [self.options.program] + [word for name, value in settings.items() for word in ("--set", "%s=%.17g" % (name, value))]
        counts = Counts()

        def run(path, channel=None):
            found = detect(command, path, channel)
            if found.failure:
                sys.exit("%s: %s" % (path, found.failure))
            counts.cpu_s += found.cpu_s
            return found

        for folder in self.options.recordings:
            for path, truth in annotated(folder):
                if self.is_used(path):
                    counts.add_impacts(os.path.basename(os.path.normpath(folder)), *score_recording(run(path), truth))
        for column, path, truth in self.scenes:
            if self.is_used(path):
                self.add_truth(counts, column, "generated", truth, run(path), 3e-3)
        for folder in self.options.onset_cases:
            for path, recording in onset_cases.cases_in(folder):
                if not self.is_used(recording):
                    continue
                truth = onset_cases.truth_of(path)[0]
                self.add_truth(counts, "onset cases", "generated", truth, run(recording), 1e-3, 30e-3)
                if os.path.basename(path)[:3] in self.options.codec_cases:
                    for encoder in lossy.ENCODERS:
                        self.add_truth(counts, "codecs", "codecs", truth, run(lossy.through(encoder, recording, self.options.work)), 3e-3, 60e-3)
        for folder in self.options.channels:
            for path in filter(self.is_used, sound.below(folder)):
                if channels.two_sounds(path):
                    differences, sigma, _ = channels.compared(run(path, 0), run(path, 1))
                    counts.add_errors("two channels", differences, sigma)
        counts.invented = sum(run(piece).n_drops for path, piece in self.no_ball if self.is_used(path))
        return counts

    @staticmethod
    def add_truth(counts, column, of_errors, truth, found, tolerance_s, reach_s=12e-3):
        i, j, _ = match.matched(truth, found.t_s, tolerance_s, reach_s)
        counts.add_impacts(column, len(truth), len(i), len(found.t_s))
        counts.add_errors(of_errors, *intervals(truth, found, i, j))


def lines_of(options):
    if options.set:
        return [("; ".join(options.set), {name: float(value) for name, value in (text.split("=") for text in options.set)})]
    if options.pairs:
        return [(" and ".join(two), {**PARTS[two[0]], **PARTS[two[1]]}) for two in itertools.combinations(options.only, 2)]
    return [(name, PARTS[name]) for name in options.only]


def main():
    options = arguments()
    with tempfile.TemporaryDirectory() as scratch:
        options.work = options.work or scratch
        os.makedirs(options.work, exist_ok=True)
        sets = Sets(options)
        whole = sets.score({})
        heads = ["without", *whole.counts, *("log score: " + name for name in whole.errors), "invented", "time"]
        print("| " + " | ".join(heads) + " |\n|" + "---|" * len(heads))
        print("| nothing | " + " | ".join(whole.cells()) + " | 1 |", flush=True)
        for name, settings in lines_of(options):
            counts = sets.score(settings)
            cells = ["" if cell == as_whole else cell for cell, as_whole in zip(counts.cells(), whole.cells())]
            print("| %s | %s | %.2f |" % (name, " | ".join(cells), counts.cpu_s / whole.cpu_s), flush=True)


if __name__ == "__main__":
    main()
