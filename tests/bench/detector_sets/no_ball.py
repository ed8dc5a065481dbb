# SPDX-License-Identifier: GPL-3.0-or-later
"""Sound that holds no ball: invented drops an hour, by top-level folder, and the speed.

All of it takes long: a sample of it is drawn, folder by folder in turn and by a seed, until there are enough hours, and of a long
file one piece at a place drawn at random."""
import os
import subprocess

import numpy as np

import sound
from bars import Bar, by_cell, ratio, total
from program import detect

TITLE = "sound without a ball"


def groups_of(folder):
    """{top-level folder: its files}; the folder's own name where it has one only, and for files that lie in itself."""
    own, groups = os.path.basename(os.path.abspath(folder)), {}
    for path in sound.below(folder):
        first, _, rest = os.path.relpath(path, folder).partition(os.sep)
        groups.setdefault(first if rest else own, []).append(path)
    return groups if len(groups) > 1 else {own: paths for paths in groups.values()}


def piece_of(path, length_s, options, rng):
    """The path itself, or that of a piece of it; and its length in seconds."""
    if not options.piece_s or length_s <= 1.5 * options.piece_s:
        return path, length_s
    begin_s = rng.uniform(0, length_s - options.piece_s)
    stem = os.path.splitext(os.path.relpath(path, os.sep))[0].replace(os.sep, "+")
    out = os.path.join(options.work, "%s_%.0f.wav" % (stem[-120:], begin_s))
    if not os.path.exists(out):
        subprocess.run(["ffmpeg", "-v", "error", "-y", "-ss", "%.3f" % begin_s, "-t", "%g" % options.piece_s, "-i", path, "-c:a", "pcm_s24le", out], check=True)
    return out, options.piece_s


def sampled(options):
    """(group, file, file or piece to read), the same for every program and every order of the folders."""
    groups = {}
    for folder in options.no_ball:
        for name, paths in groups_of(folder).items():
            groups.setdefault(name, []).extend(paths)
    orders = {name: list(np.random.default_rng(options.seed).permutation(paths)) for name, paths in sorted(groups.items())}
    limit_s, used_s = 3600 * options.hours / max(1, len(orders)), dict.fromkeys(orders, 0.0)
    rng = np.random.default_rng(options.seed)
    for name, paths in orders.items():
        for path in map(str, paths):
            header = sound.header_of(path)
            if used_s[name] >= limit_s:
                break
            if header and header[2] > 0:
                piece, length_s = piece_of(path, header[2], options, rng)
                used_s[name] += length_s
                yield name, path, piece


def measure(program, options):
    for group, path, piece in sampled(options):
        found = detect(program, piece, None, options.timeout_s)
        drops = [{"n": int(np.sum(found.drop == d)), "t_s": [round(float(t), 4) for t in found.t_s[found.drop == d][:12]]} for d in sorted(set(found.drop))]
        yield {"file": os.path.basename(path), "path": piece, "cell": group, "n_drops": found.n_drops, "drops": drops,
               "duration_s": found.duration_s, "cpu_s": found.cpu_s, "failure": found.failure}


def slowest(records):
    """Times real time; a short file is all start of the program."""
    return min((r["duration_s"] / r["cpu_s"] for r in records if r["duration_s"] >= 10), default=float("nan"))


def bars(records):
    def an_hour(some):
        return ratio(total(some, "n_drops"), total(some, "duration_s") / 3600)
    out = [Bar("invented an hour", an_hour(records), most=0.5), Bar("hours of sound", total(records, "duration_s") / 3600),
           Bar("files that failed", sum(bool(r["failure"]) for r in records)),
           Bar("x real time", ratio(total(records, "duration_s"), total(records, "cpu_s"))),
           Bar("x real time, slowest file of 10 s or more", slowest(records), least=200)]
    for name, some in by_cell(records).items():
        out += [Bar("%s: invented" % name[:34], total(some, "n_drops")), Bar("%s: hours" % name[:34], total(some, "duration_s") / 3600),
                Bar("%s: x real time" % name[:34], ratio(total(some, "duration_s"), total(some, "cpu_s")))]
    return out


def remarks(records):
    for r in records:
        if r["n_drops"]:
            yield "%s/%s: drops of %s impacts, at %s s" % (r["cell"], r["file"], [d["n"] for d in r["drops"]], r["drops"][0]["t_s"])
        elif r["failure"]:
            yield "%s/%s: %s" % (r["cell"], r["file"], r["failure"][-100:])
    speed = sorted((r["duration_s"] / r["cpu_s"], r["path"]) for r in records if r["duration_s"] >= 10)
    for times, path in speed[:5]:
        yield "%s: %.1f x real time" % (path, times)
