# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures how fast bouncelab is, beside named baselines in the same run, and writes that as a page.

    tools/bench                                  everything, 10 minutes on two cores: docs/performance.md
    tools/bench --quick                          a try of a minute or two: out/performance.md
    tools/bench --only start-up simulate         some parts: out/performance.md
    tools/bench --page-of out/performance.jsonl  the page again from what was measured: out/performance.md

Installs and builds what is missing (Release), prints progress to standard error. What was measured is kept in out/performance.jsonl, one
number a line. The page is written whole or not at all. On a machine that does other work too figures are larger than they should be: the
page states the load; the ratios of one run bear it better than seconds.
"""
import argparse
import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(1, str(Path(__file__).resolve().parents[1]))

import machine
from measured import Measured
from page import page_of

ROOT = Path(__file__).resolve().parents[3]
HERE = Path(__file__).resolve().parents[1]
PYTHON = "/usr/bin/python3" if os.access("/usr/bin/python3", os.X_OK) else sys.executable


def commands(options, work):
    """The commands of each part, in the order of the page."""
    build = options.programs or ROOT / "build" / "release"
    program = build / "tools" / "bouncelab" / "bouncelab"
    compiled = lambda name, *words: [build / "tests" / "bench" / name, *words]
    script = lambda name, *words: [PYTHON, HERE / name, *words]
    quick = options.quick
    samples = 3000 if quick else 100000
    timing = ("0.2 of the scatter", "1.7 of the scatter")
    return {
        "loop": [script("loop_bench.py", program, *(["--drops", 20] if quick else []))],
        "detect": [script("detection_bench.py", program, *(["--runs", 2, "--minutes", 2, "--hour", 4] if quick else [])),
                   compiled("noise_bench")],
        "synthesize": [compiled("synthesis_bench")],
        "simulate": [compiled("sim_bench", "1e5" if quick else options.asperities)],
        "fit": [compiled("fit_bench", samples, work),
                *[script("fit_iminuit.py", work / f"{samples} samples, timing noise {noise}.csv") for noise in timing]],
        "start-up": [script("start_up.py", program, "--runs", 5 if quick else 200)],
        "machine": [compiled("machine_bench"), compiled("kernels_bench")],
        "growth": [script("growth_bench.py", program, *(["--quick", "--runs", 1] if quick else []))],
    }


def lines_of(command):
    """What a benchmark prints. Its messages go to standard error as they come."""
    run = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, text=True, check=False,
                         env=os.environ | {"PYTHONDONTWRITEBYTECODE": "1", "OMP_NUM_THREADS": "1"})
    if run.returncode != 0:
        sys.exit(f"tools/bench: failed: {' '.join(map(str, command))}")
    return [json.loads(line) for line in run.stdout.splitlines()]


def build():
    subprocess.run([ROOT / "tools" / "setup", "--bench"], check=True, stdout=sys.stderr)
    subprocess.run([ROOT / "tools" / "build", "bouncelab_command", "benchmarks"], check=True, stdout=sys.stderr)


def measured(options, work):
    if not options.programs:
        print("tools/bench: building", file=sys.stderr)
        build()
    parts = commands(options, work)
    chosen = [part for part in parts if not options.only or part in options.only]
    lines = machine.lines(options.programs or ROOT / "build" / "release", "begin")
    limits = (["quick: short recordings, few runs"] if options.quick else []) + (["parts: " + ", ".join(chosen)] if options.only else [])
    if limits:
        lines.append({"part": "run", "case": "machine", "what": "not the whole", "value": "; ".join(limits), "unit": ""})
    begin = time.monotonic()
    for k, part in enumerate(chosen):
        print(f"tools/bench: {k + 1} of {len(chosen)}: {part} ({time.monotonic() - begin:.0f} s so far)", file=sys.stderr)
        for command in parts[part]:
            lines += lines_of(command)
    lines += machine.lines(None, "end")
    lines.append({"part": "run", "case": "", "what": "seconds", "value": time.monotonic() - begin, "unit": "s"})
    return lines


def write_whole(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    unfinished = path.with_name(path.name + f".{os.getpid()}.part")
    unfinished.write_text(text, encoding="utf-8")
    unfinished.replace(path)


def main():
    parser = argparse.ArgumentParser(prog="tools/bench", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    names = ["loop", "detect", "synthesize", "simulate", "fit", "start-up", "machine", "growth"]
    parser.add_argument("--quick", action="store_true", help="short recordings, few runs")
    parser.add_argument("--only", nargs="+", metavar="PART", choices=names, help="of: " + ", ".join(names))
    parser.add_argument("--asperities", default="1e6", metavar="N", help="the largest ball of `simulate` (default 1e6)")
    parser.add_argument("--out", type=Path, metavar="PAGE", help="the page (default docs/performance.md where everything is measured, else out/performance.md)")
    parser.add_argument("--programs", type=Path, metavar="DIR", help="take the programs of this build folder, install and build nothing")
    parser.add_argument("--page-of", type=Path, metavar="LINES", help="measure nothing: the page of these lines")
    options = parser.parse_args()
    whole = not options.only and not options.quick
    out = options.out or ROOT / ("docs/performance.md" if whole else "out/performance.md")
    if options.page_of:
        out = options.out or options.page_of.with_suffix(".md")
        lines = [json.loads(line) for line in options.page_of.read_text(encoding="utf-8").splitlines()]
    else:
        work = ROOT / "out" / f"bench.{os.getpid()}"
        work.mkdir(parents=True)
        try:
            lines = measured(options, work)
        finally:
            shutil.rmtree(work)
        kept = out.with_suffix(".jsonl") if options.out else ROOT / "out" / "performance.jsonl"
        write_whole(kept, "".join(json.dumps(line, ensure_ascii=False) + "\n" for line in lines))
    write_whole(out, page_of(Measured(lines)))
    print(f"tools/bench: {out}", file=sys.stderr)


main()
