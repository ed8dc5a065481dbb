# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures how fast bouncelab is against named baselines in the same run, and writes the ratios as a page.

    tools/bench                        everything, some 5 minutes on two cores: docs/performance.md
    tools/bench --quick                a try of a minute: out/performance.md
    tools/bench --only start simulate  some parts: out/performance.md

Installs and builds what is missing (Release) and prints progress to standard error. The page is written whole or not at all. No bar is
in seconds: another machine, or other work on it, changes seconds a lot and ratios little.
"""
import argparse
import os
import platform
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from bench_lines import Bench, Row, alternating, cost_of, least_cpu_s, median_wall_s, seconds

ROOT = Path(__file__).resolve().parents[2]
HERE = Path(__file__).resolve().parent


def synthesize(bench):
    for rate, value in bench.compiled("synthesis_bench").items():
        for what, bar in (("one point a drop", ("at least", 80) if rate == "96000 Hz" else None), ("a point for each impact", None)):
            yield Row(f"synthesize, {rate.replace('000 Hz', ' kHz').replace('00 Hz', ' kHz')}, {what}: the direct sum over bouncelab", value["direct sum"] / value[what], bar,
                      f"a second of sound, noise included: {seconds(value[what])}; each impact adds each mode of the plate, no noise: {seconds(value['direct sum'])}")


def simulate(bench):
    for case, value in bench.compiled("sim_bench", "1e5" if bench.quick else "1e6").items():
        yield Row(f"simulate, radii `{case.replace(',', ', ').replace('  ', ' ')}`: an impact over the smooth ball's", value["impact"] / value["impact of the smooth ball"],
                  ("at most", 4) if case.startswith("constant") else None,
                  f"200 drops of 100 impacts: {seconds(value['impact'])}; smooth {seconds(value['impact of the smooth ball'])}; envelope, once a ball, {seconds(value['envelope'])}")


def fit(bench):
    n_samples = 3000 if bench.quick else 100000
    ours = bench.compiled("fit_bench", n_samples, bench.folder)
    for table in sorted(bench.folder.glob(f"{n_samples} samples*.csv")):
        ((case, theirs),) = bench.values(sys.executable, HERE / "fit_iminuit.py", table).items()
        ours_s, minuit_s = ours[case]["law with profile intervals"], theirs["iminuit, profile intervals"]
        yield Row(f"fit, {case}: iminuit over bouncelab", minuit_s / ours_s, ("at least", 20), f"ε(v) with profile intervals: {seconds(ours_s)}; the same likelihood in NumPy, MIGRAD and MINOS: {seconds(minuit_s)}")


def fit_with_memory(bench):
    """The default of the command line, from 5 drops of 30 impacts on."""
    tables, n_drops = [bench.folder / name for name in ("drops.csv", "drops-samples.csv", "drops-fit.json")], 5 if bench.quick else 20
    cost_of([bench.program, "simulate", "--drops", n_drops, "--out", tables[0]])
    cost_of([bench.program, "restitution", tables[0], "--out", tables[1]])
    words = [bench.program, "fit", tables[1], "--out", tables[2], "--force", "--quiet", "--threads", 1]
    costs = alternating({"default": lambda: cost_of(words), "without": lambda: cost_of([*words, "--method", "asymmetric-laplace"])}, 1 if bench.quick else 3)
    default_s, without_s = least_cpu_s(costs["default"]), least_cpu_s(costs["without"])
    yield Row("fit as the command does it, with memory, over `--method asymmetric-laplace`, without", default_s / without_s, None, f"{n_drops} drops of 100 impacts: {seconds(default_s)}; {seconds(without_s)}")


def start(bench):
    """On the clock, which is what who waits for a start sees."""
    detect_words = [bench.program, "detect", ROOT / "samples" / "clean.flac", "--out", bench.folder / "onsets.csv", "--force", "--quiet"]
    commands = {"python": [sys.executable, "-c", "pass"], "version": [bench.program, "--version"], "detect": detect_words}
    n_runs = 5 if bench.quick else 100
    wall_s = {name: median_wall_s(costs) for name, costs in alternating({name: lambda words=words: cost_of(words) for name, words in commands.items()}, n_runs).items()}
    peer = f"`python3 -c pass` {seconds(wall_s['python'])}; medians of {n_runs} on the clock"
    yield Row("start over `python3 -c pass`", wall_s["version"] / wall_s["python"], ("at most", 1), f"`bouncelab --version`: {seconds(wall_s['version'])}; {peer}")
    yield Row("detect in 12 s of sound over `python3 -c pass`", wall_s["detect"] / wall_s["python"], ("at most", 3), f"`samples/clean.flac`: {seconds(wall_s['detect'])}; {peer}")


def kernels(bench):
    for case, value in bench.compiled("kernels_bench").items():
        yield Row(f"{case}: a plain loop over bouncelab", value["a plain loop"] / value["bouncelab"], None, f"{seconds(value['bouncelab'])}; {seconds(value['a plain loop'])}")


def detect(bench):
    import detection_bench  # which needs SciPy, as the parts below do not
    yield from detection_bench.rows(bench)


PARTS = {part.__name__: part for part in (detect, synthesize, simulate, fit, fit_with_memory, start, kernels)}

INTRODUCTION = """# Performance

How fast bouncelab is against what one would use otherwise. `tools/bench` wrote this page in one run; it is not edited by hand.

- **Ratios of one run.** Each program stands beside a named baseline that took turns with it in this run. *Over*: the time of the
  first divided by that of the second. *met* and *missed* say what this run found; no test asserts a time.
- **Times** are of processors, user and system, the least of several runs; one thread, where no number of cores is given. Commands count
  from the start of the program to their output.
- `aubioonset` is a general onset detector in C. *SciPy* is what one would write in an afternoon, a trigger, a stack and a cross-correlation
  (`tests/bench/trigger_stack.py`), without the start of Python and its imports. The two numbers after a detector's time
  are the share of impacts that it finds within 1 ms and the share of its onsets that are impacts.
- Sounds without a ball are silence, noise, a tone, clicks, and bursts of coloured noise as in speech or music (`tests/bench/sounds.py`).
"""


def output_of(*command):
    """The first line, or "not installed"."""
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.split("\n")[0]
    except (OSError, subprocess.CalledProcessError):
        return "not installed"


def machine(bench):
    """On what it was measured: without that a ratio means little."""
    cpu = re.findall(r"^(?:model name|cpu family|model)\s*: (.*)", Path("/proc/cpuinfo").read_text(), re.M)[:3]
    compiler = re.search(r"^CMAKE_CXX_COMPILER:[A-Z]*=(.*)", (bench.build / "CMakeCache.txt").read_text(), re.M).group(1)
    packages = ("aubio-tools", "python3-scipy", "python3-numpy", "python3-iminuit", "libfftw3-single3", "libsndfile1")
    versions = [f"{package} {output_of('dpkg-query', '-W', '-f', '${Version}', package)}" for package in packages]
    return [("date", time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime())), ("bouncelab", output_of(bench.program, "--version")),
            ("processor", f"{len(os.sched_getaffinity(0))} cores of {cpu[2]} (family {cpu[0]}, model {cpu[1]})" if len(cpu) == 3 else platform.machine()),
            ("compiler", output_of(compiler, "--version")), ("others", ", ".join(versions + [f"Python {platform.python_version()}"]))]


def page_of(rows, facts):
    table = lambda header, lines: "\n".join("| " + " | ".join(cells) + " |" for cells in [header, ("---",) * len(header), *lines]) + "\n"
    return "\n".join([INTRODUCTION, table(("what", "ratio", "bar", "measured"), [row.cells() for row in rows]), table(("machine", ""), facts)])


def load():
    return " ".join(f"{value:.1f}" for value in os.getloadavg())


def main():
    parser = argparse.ArgumentParser(prog="tools/bench", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="short recordings, few runs")
    parser.add_argument("--only", nargs="+", metavar="PART", choices=PARTS, default=list(PARTS), help="of: " + ", ".join(PARTS))
    parser.add_argument("--out", type=Path, metavar="PAGE", help="the page (default docs/performance.md where everything is measured, else out/performance.md)")
    parser.add_argument("--programs", type=Path, metavar="DIR", help="take the programs of this build folder, install and build nothing")
    options = parser.parse_args()
    if not options.programs:
        subprocess.run([ROOT / "tools" / "setup", "--bench"], check=True, stdout=sys.stderr)
        subprocess.run([ROOT / "tools" / "build", "bouncelab_command", "benchmarks"], check=True, stdout=sys.stderr)
    whole = len(options.only) == len(PARTS) and not options.quick
    out = options.out or ROOT / ("docs/performance.md" if whole else "out/performance.md")
    out.parent.mkdir(parents=True, exist_ok=True)
    load_before, begin, rows = load(), time.monotonic(), []
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(options.programs or ROOT / "build" / "release", Path(folder), options.quick)
        for part in options.only:
            print(f"tools/bench: {part} ({time.monotonic() - begin:.0f} s so far)", file=sys.stderr)
            rows += PARTS[part](bench)
        facts = machine(bench) + [("load before and after", f"{load_before}; {load()} (1, 5, 15 min)"), ("the run", f"{(time.monotonic() - begin) / 60:.1f} min")]
    if not whole:
        facts.append(("not the whole", f"{'quick; ' if options.quick else ''}{', '.join(options.only)}"))
    unfinished = out.with_name(f"{out.name}.{os.getpid()}.part")
    unfinished.write_text(page_of(rows, facts), encoding="utf-8")
    unfinished.replace(out)
    print(f"tools/bench: {out}", file=sys.stderr)


if __name__ == "__main__":
    main()
