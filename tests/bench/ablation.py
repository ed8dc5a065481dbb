#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What each part of the detector is worth: the sets of recordings with it and without it, as the table of docs/detector.md.

    tools/build detect_with bouncelab
    python3 tests/bench/ablation.py [--only PART ...] [--pairs] [--recordings DIR ...] [--channels DIR] [--onset-cases DIR] [--no-ball DIR]

A part is taken out by one number of the models (tests/bench/model_numbers.hpp), at which it does nothing. --pairs takes out every two
of the parts named. `bouncelab validate` scores each set. Each line has recall / precision within 5 ms on each folder of annotated recordings
(NAME.wav, NAME.truth.csv with t_s), on generated drops of few bounces, in clutter, and of two balls at once or one ball at six places
(tests/bench/scenes), of onset cases (NAME.wav, NAME.json with impacts[] of t_s, v, crb_us) and through codecs; the log score of stated errors
(docs/validation.md) and in brackets the pull against the truth, through codecs, and between the two channels of --channels; files without a
ball in which one was invented; processor time over that of the whole.
--part build decides, --part held-out reports: halves of every set by a hash of the file's name. Needs python3-numpy and ffmpeg.
"""
import argparse
import csv
import hashlib
import itertools
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "scenes"))

import numpy as np  # noqa: E402

import sound  # noqa: E402
from make import make_all  # noqa: E402

BUILD = os.path.join(HERE, "../../build/release")
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
    "power of the loudness": {"kTracking.loudness_exponent": 1, "kTracking.exponent_scatter": 1e-3},
    "lower bands": {"kTracking.lower_band": NEVER},
    "lower bands only where unclear": {"kChannels.explained": 2},
    "long template": {"kTemplate.many_close": NEVER},
    "several beginnings": {"kTemplate.most_starts": 1},
    "0.01 not repeated": {"kTemplate.unrepeated": 0},
    "whitening by residuals": {"kTemplate.residual_order": 0},
    "coherence weight": {"kTemplate.fewest_for_coherence": NEVER},
    "weak bands merged": {"kTemplate.least_information_share": 0},
    "amplitudes of sub-bands": {"kTemplate.amplitude_prior": NEVER},
    "jitter of one band": {"kTemplate.fewest_subbands": 0},
    "chi2 of the bands": {"kTemplate.prior_subbands": NEVER},
    "gaps": {"kDelay.least_in_gap": NEVER},
    "beyond the end": {"kDelay.least_of_outlier": NEVER},
    "far places": {"kDelay.much_left": NEVER},
    "forward-backward": {"kDelay.fewest_impacts": NEVER},
    "own template of a drop": {"kDrops.own_template": NEVER},
    "timed in the whole sound": {"kDrops.clearly_less": 0},
    "other bands": {"kDrops.fewest_shared": NEVER},
    "contact time fitted": {"kContact.fewest_impacts": NEVER},
    "contact time": {"kContact.fewest_impacts": NEVER, "kContact.duration_times_frequency": 0},
}

GENERATED = ("few", "clutter", "drops")  # folders of tests/bench/scenes
ENCODERS = {"aac64": ("m4a", "aac", "-b:a", "64k"), "aac128": ("m4a", "aac", "-b:a", "128k"), "vorbis4": ("ogg", "libvorbis", "-q:a", "4"),
            "mp3_64": ("mp3", "libmp3lame", "-b:a", "64k"), "mp3_128": ("mp3", "libmp3lame", "-b:a", "128k"),
            "opus32": ("opus", "libopus", "-b:a", "32k"), "opus64": ("opus", "libopus", "-b:a", "64k")}
ENCODED = ("c03", "c05", "c06", "c11")  # of the onset cases: beginnings of their names
PIECE_S, SHORTEST_S = 60, 0.2  # of sound without a ball
LONGEST_S = 1.0  # interval compared between channels
EXTENSIONS = ("wav", "ogg", "oga", "flac", "mp3", "aiff", "aif", "opus")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=list(PARTS), default=list(PARTS), metavar="PART")
    parser.add_argument("--pairs", action="store_true", help="every two of the parts together")
    parser.add_argument("--part", choices=("build", "held-out"), help="one half of every set")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="a line with other numbers, in place of the parts")
    parser.add_argument("--program", default=os.path.join(BUILD, "tests/bench/detect_with"), help="detect_with (%(default)s)")
    parser.add_argument("--hours", type=float, default=1.0, help="of sound without a ball (%(default)s)")
    parser.add_argument("--cases", type=int, default=8, help="generated recordings of each kind (%(default)s)")
    parser.add_argument("--work", metavar="DIR", help="keep encoded and generated sounds here, and take them from here again")
    parser.add_argument("--recordings", action="append", default=[], metavar="DIR")
    for name in ("channels", "onset-cases", "no-ball"):
        parser.add_argument("--" + name, metavar="DIR")
    return parser.parse_args()


def ffmpeg(*words):
    subprocess.run(["ffmpeg", "-v", "error", "-y", *words], check=True)


def make_onset_cases(source, plain, encoded):
    """Truth as validate reads it; some of them through encoders."""
    for folder in (plain, encoded):
        os.makedirs(folder, exist_ok=True)
    for name in sorted(name[:-5] for name in os.listdir(source) if name.endswith(".json")):
        wav = os.path.join(source, name + ".wav")
        with open(os.path.join(source, name + ".json")) as file:
            impacts = sorted(json.load(file)["impacts"], key=lambda impact: impact["t_s"])
        rows = [(i["drop"], i["t_s"], 1e-6 * i["crb_us"], i["v"]) for i in impacts]
        stems = {os.path.join(plain, name): None, **{os.path.join(encoded, name + "_" + e): how for e, how in ENCODERS.items() if name[:3] in ENCODED}}
        for stem, how in stems.items():
            sound.write_truth(stem + ".truth.csv", ("drop", "t_s", "sigma_t_s", "v_mps"), rows)
            if how and not os.path.exists(stem + ".wav"):
                ffmpeg("-i", wav, "-c:a", *how[1:], stem + "." + how[0])
                ffmpeg("-i", stem + "." + how[0], "-c:a", "pcm_s24le", stem + ".wav")
                os.remove(stem + "." + how[0])
            elif not how:
                shutil.copyfile(wav, stem + ".wav")


def make_no_ball(source, folder, hours):
    """Files in an order drawn at random, of long ones a minute at a place drawn at random, until there are enough hours."""
    os.makedirs(folder, exist_ok=True)
    paths = sorted(os.path.join(place, name) for place, _, names in os.walk(source) for name in names if name.lower().endswith(EXTENSIONS))
    paths = [path for path in paths if not os.path.islink(path)]  # a link is no second file
    rng, used_s = np.random.default_rng(1), 0.0
    for k in rng.permutation(len(paths)):
        try:
            length_s = float(printed(["ffprobe", "-v", "error", "-show_entries", "format=duration", "-of", "csv=p=0", paths[k]])[0])
        except subprocess.CalledProcessError:
            continue  # no sound
        if length_s < SHORTEST_S:
            continue
        begin_s, length_s = rng.uniform(0, max(0, length_s - PIECE_S)), min(length_s, PIECE_S)
        stem = os.path.join(folder, "%04d_%s" % (k, os.path.basename(paths[k]).rpartition(".")[0]))
        if not os.path.exists(stem + ".wav"):
            ffmpeg("-ss", "%.3f" % begin_s, "-t", "%g" % PIECE_S, "-i", paths[k], "-c:a", "pcm_s24le", stem + ".wav")
            sound.write_truth(stem + ".truth.csv", ("t_s",), [])
        used_s += length_s
        if used_s >= 3600 * hours:
            break


def columns_of(options):
    """{column: folder that validate reads}, made once."""
    columns = {os.path.basename(os.path.normpath(folder)): folder for folder in options.recordings}
    make_all(options.work, options.cases, 1, GENERATED)
    columns.update({name: os.path.join(options.work, name) for name in GENERATED})
    if options.onset_cases:
        columns.update({name: os.path.join(options.work, name) for name in ("onset cases", "codecs")})
        make_onset_cases(options.onset_cases, columns["onset cases"], columns["codecs"])
    if options.no_ball:
        columns["no ball"] = os.path.join(options.work, "no ball")
        make_no_ball(options.no_ball, columns["no ball"], options.hours)
    return columns


def is_used(name, part):
    """Half of any set, by a hash of the file's name without its ending: the same for ever."""
    return not part or ("build", "held-out")[hashlib.sha256(name.encode()).digest()[0] % 2] == part


def scores(options, command, folder, annotated):
    """Rows of scores.csv of the recordings that are used."""
    with tempfile.TemporaryDirectory() as out:
        subprocess.run([os.path.join(BUILD, "tools/bouncelab/bouncelab"), "validate", "--recordings", folder, "--truth", folder, "--detector",
                        " ".join(command + ["{wav}"]), "--out", out, "--force", "--quiet", *(["--annotated-only"] if annotated else [])], check=True)
        with open(os.path.join(out, "scores.csv"), newline="") as file:
            rows = [row for row in csv.DictReader(file) if is_used(row["recording"], options.part)]
    for row in rows:
        if row["failure"]:
            sys.exit("%s: %s" % (row["recording"], row["failure"]))
    return rows


def total(rows, key, weight):
    return sum(float(row[key] or 0) * float(row[weight] or 0) for row in rows)


def recall_and_precision(rows):
    n_true, n_marked = (sum(float(row[key]) for row in rows) for key in ("n_true", "n_marked"))
    n_found = total(rows, "recall_5ms", "n_true")
    return "%.3f / %.3f" % (n_found / n_true, n_found / max(1, n_marked))


def log_score(rows):
    """Mean over the intervals, and the root mean square pull."""
    n = sum(float(row["n_stated"]) for row in rows)
    pull2 = sum(float(row["pull"] or 0)**2 * float(row["n_stated"]) for row in rows) / n
    return "%.2f (%.2f)" % (total(rows, "log_score", "n_stated") / n, pull2**0.5)


def between_channels(options, command):
    """Differences of intervals over their stated errors, of each recording whose channels are no copies of each other."""
    errors, sigmas = [], []
    for name in sorted(os.listdir(options.channels)):
        path = os.path.join(options.channels, name)
        if not name.endswith(".wav") or not is_used(name[:-4], options.part) or n_channels(path) != 2:
            continue
        left, right = (np.array([line.split() for line in printed(command + ["--channel", c, path])], float).reshape(-1, 2) for c in "01")
        if not len(left) or not len(right) or np.array_equal(left, right):
            continue
        nearest = np.abs(right[:, 0] - left[:, :1]).argmin(1)
        use = np.abs(right[nearest, 0] - left[:, 0]) < 5e-3
        follows = use[1:] & use[:-1] & (np.diff(nearest) == 1) & (np.diff(left[:, 0]) < LONGEST_S)
        variance = left[:, 1]**2 + right[nearest, 1]**2
        errors += list(np.diff(right[nearest, 0] - left[:, 0])[follows])
        sigmas += list(np.sqrt(variance[1:] + variance[:-1])[follows])
    pulls, sigmas = np.array(errors) / sigmas, np.array(sigmas)
    return "%.2f (%.2f)" % (np.mean(-np.log(1e6 * sigmas) - 0.5 * np.minimum(pulls**2, 25)), np.mean(pulls**2)**0.5)


def n_channels(path):
    return int(printed(["ffprobe", "-v", "error", "-show_entries", "stream=channels", "-of", "csv=p=0", path])[0])


def printed(command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.split("\n")[:-1]


def cells_of(options, columns, settings):
    """A line of the table, and the processor time of it."""
    command = [options.program] + [word for name, value in settings.items() for word in ("--set", "%s=%.17g" % (name, value))]
    begin = resource.getrusage(resource.RUSAGE_CHILDREN)
    rows = {name: scores(options, command, folder, folder in options.recordings) for name, folder in columns.items()}
    without_ball = rows.pop("no ball", [])
    cells = {name: recall_and_precision(some) for name, some in rows.items()}
    cells["log score: generated"] = log_score([row for name in (*GENERATED, "onset cases") for row in rows.get(name, [])])
    if "codecs" in rows:
        cells["log score: codecs"] = log_score(rows["codecs"])
    if options.channels:
        cells["log score: two channels"] = between_channels(options, command)
    cells["invented"] = "%d" % sum(float(row["n_marked"]) > 0 for row in without_ball)
    end = resource.getrusage(resource.RUSAGE_CHILDREN)
    return cells, end.ru_utime + end.ru_stime - begin.ru_utime - begin.ru_stime


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
        columns = columns_of(options)
        whole, whole_s = cells_of(options, columns, {})
        print("| without | " + " | ".join(whole) + " | time |\n|" + "---|" * (len(whole) + 2))
        print("| nothing | " + " | ".join(whole.values()) + " | 1 |", flush=True)
        for name, settings in lines_of(options):
            cells, cpu_s = cells_of(options, columns, settings)
            print("| %s | %s | %.2f |" % (name, " | ".join("" if cell == whole[head] else cell for head, cell in cells.items()), cpu_s / whole_s), flush=True)


if __name__ == "__main__":
    main()
