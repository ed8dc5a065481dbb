#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluates the detector: one or two programs over sets of recordings, every bar with its threshold, old beside new.

    python3 tests/bench/detector_sets --new BOUNCELAB [--old BOUNCELAB] [--recordings DIR] [--no-ball DIR] [--codecs DIR] ...

No set is needed, and one that is not there is skipped, saying so:
  --recordings   NAME.wav with NAME.truth.csv (header t_s): recall and precision within 3 ms, each also cut, delayed and by channels
  --no-ball      folders of sound without a ball: invented drops an hour for each top-level folder, and the speed
  --codecs       onset cases to be sent through ffmpeg's encoders
  --channels     folders of stereo recordings of a ball: one channel's intervals against the other's
  --onset-cases  NAME.wav with NAME.json (impacts[] of t_s, drop, v, crb_us)
  --generated    few, no-ball, clutter, stereo, speed (all unless named): made here, by a generator of its own
Each set is in two parts by a hash of the file's name: to build on, and held out, which no constant is fitted on and no rule made for.
A value that misses its bar is marked with !. Exit code 1 where one of --new does. Needs python3-numpy and ffmpeg.
"""
import argparse
import json
import os
import sys
import tempfile

sys.dont_write_bytecode = True  # no __pycache__ in the sources
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import bars  # noqa: E402
import channels  # noqa: E402
import generated  # noqa: E402
import lossy  # noqa: E402
import no_ball  # noqa: E402
import onset_cases  # noqa: E402
import recordings  # noqa: E402
import speed  # noqa: E402
import stereo  # noqa: E402

FOLDER_SETS = {"recordings": recordings, "no_ball": no_ball, "onset_cases": onset_cases, "codecs": lossy, "channels": channels}
GENERATED_SETS = {"few": generated.FewBounces, "no-ball": generated.NoBall, "clutter": generated.Clutter, "stereo": stereo, "speed": speed}


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--old", help="a bouncelab program to compare with")
    parser.add_argument("--new", help="the bouncelab program in question")
    for name in FOLDER_SETS:
        parser.add_argument("--" + name.replace("_", "-"), action="append", default=[], metavar="DIR")
    parser.add_argument("--generated", nargs="*", choices=list(GENERATED_SETS), metavar="SET")
    parser.add_argument("--codec-cases", default="c03,c05,c06,c11", help="beginnings of the names of the cases for --codecs (%(default)s)")
    parser.add_argument("--cases", type=int, default=12, help="generated recordings of each kind (%(default)s)")
    parser.add_argument("--hours", type=float, default=1.0, help="of sound without a ball, shared by its folders (%(default)s)")
    parser.add_argument("--piece-s", type=float, default=60, help="longer files without a ball are read in one piece of this length; 0: whole (%(default)s)")
    parser.add_argument("--timeout-s", type=float, default=600, help="of one recording; longer is a failure (%(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of what is drawn and generated (%(default)s)")
    parser.add_argument("--json", metavar="FILE", help="all bars, and what was counted in each file")
    parser.add_argument("--work", metavar="DIR", help="keep pieces, encoded and generated sounds here, and take them from here again")
    parser.add_argument("--remarks", action="store_true", help="also name every file in which something was missed or invented")
    options = parser.parse_args()
    if not options.old and not options.new:
        parser.error("--new or --old is needed")
    for program in (options.old, options.new):
        if program and not os.path.isfile(program):
            parser.error("%s: no such program" % program)
    return options


def sets_of(options):
    """The sets that were asked for and are there."""
    for name, measuring in FOLDER_SETS.items():
        given = getattr(options, name)
        setattr(options, name, [folder for folder in given if os.path.isdir(folder)])
        for folder in given:
            if not os.path.isdir(folder):
                print("skipped: %s is not there (%s)" % (folder, measuring.TITLE))
        if getattr(options, name):
            yield name, measuring
        elif not given:
            print("skipped: %s (no --%s)" % (measuring.TITLE, name.replace("_", "-")))
    if options.generated is not None:
        for name in options.generated or GENERATED_SETS:
            yield "generated " + name, GENERATED_SETS[name]


def evaluate(measuring, options):
    """(results for the table, records) of one set."""
    programs = {version: getattr(options, version) for version in ("old", "new") if getattr(options, version)}
    records = {version: list(measuring.measure(program, options)) for version, program in programs.items()}
    results = {version: bars.measured(measuring.bars, some) for version, some in records.items() if some}
    if results:
        bars.show(measuring.TITLE, results)
    else:
        print("skipped: no recordings (%s)" % measuring.TITLE)
    if options.remarks:
        for version, some in records.items():
            for line in measuring.remarks(some):
                print("  %s: %s" % (version, line))
    sys.stdout.flush()
    return results, records


def missed(results):
    return sum(bar.met() is False for bar in results.get("new", {}).get("all", []))


def main():
    options = arguments()
    options.keep = bool(options.work)
    out, n_missed = {}, 0
    with tempfile.TemporaryDirectory() as scratch:
        options.work = options.work or scratch
        os.makedirs(options.work, exist_ok=True)
        for name, measuring in sets_of(options):
            results, records = evaluate(measuring, options)
            out[name] = {"bars": bars.as_json(results), "files": records}
            n_missed += missed(results)
            if options.json:
                with open(options.json, "w") as file:
                    json.dump(out, file, indent=1)
    if options.new:
        print("\n%d bars missed by --new" % n_missed)
    return n_missed > 0


if __name__ == "__main__":
    sys.exit(main())
