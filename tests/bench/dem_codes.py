#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The figure and the table of docs/dem.md: eps(v) as fitted, and as LIGGGHTS, LAMMPS and Yade bounce it with the inputs of `bouncelab dem`.

    python3 tests/bench/dem_codes.py SAMPLES.csv FIT.json docs/dem.svg

Needs tools/setup --bench --python (the codes; Matplotlib)."""
import argparse
import csv
import itertools
import json
import pathlib
import re
import subprocess
import tempfile

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/tools/bouncelab/bouncelab"
COMMANDS = {"LIGGGHTS": ["liggghts", "-log", "none", "-in", "ball.py", "-var", "v"],
            "LAMMPS": ["lmp", "-log", "none", "-in", "ball.py", "-var", "v"],
            "Yade": ["yade", "-n", "-x", "ball.py"]}
SPEEDS_MPS = (0.2, 0.3, 0.45, 0.6, 0.9, 1.2)


def bounced(program, text, speed_mps):
    """eps that a code prints."""
    with tempfile.TemporaryDirectory() as folder:
        pathlib.Path(folder, "ball.py").write_text(text)
        done = subprocess.run([*COMMANDS[program], str(speed_mps)], cwd=folder, capture_output=True, text=True,
                              errors="replace", stdin=subprocess.DEVNULL, check=True)
    return float(re.findall(r"^eps = (\S+)", done.stdout, re.M)[-1])


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("samples", type=pathlib.Path)
    options.add_argument("fit", type=pathlib.Path)
    options.add_argument("figure", type=pathlib.Path)
    options = options.parse_args()
    fit = json.loads(options.fit.read_text())
    with open(options.samples, encoding="utf-8") as file:
        samples = [(float(row["v_mps"]), float(row["eps"])) for row in csv.DictReader(file) if not row.get("flags")]
    matplotlib.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "bouncelab", "font.family": "sans-serif"})
    figure, axes = pyplot.subplots(figsize=(7.0, 4.2), layout="constrained")
    every = max(1, len(samples) // 100)
    axes.plot(*zip(*samples[::every]), ".", color="0.75", markersize=3, label="measured")
    curve = fit["curve"]["points"]
    axes.plot([p["v_mps"] for p in curve], [p["eps"] for p in curve], color="0.2", label="fitted, ε(v)")
    print("| code | model |", " | ".join(f"{v:g}" for v in SPEEDS_MPS), "|")
    marks = {"LIGGGHTS": "o", "LAMMPS": "s", "Yade": "^"}
    for program, model in itertools.product(COMMANDS, ("constant", "viscoelastic")):
        made = subprocess.run([PROGRAM, "dem", options.fit, "--code", program.lower(), "--model", model], capture_output=True, text=True)
        if made.returncode != 0:  # the fit has no such model
            continue
        eps = [bounced(program, made.stdout, v) for v in SPEEDS_MPS]
        print(f"| {program} | {model} |", " | ".join(f"{e:.4f}" for e in eps), "|")
        axes.plot(SPEEDS_MPS, eps, marks[program], color="C0" if model == "viscoelastic" else "C1",
                  markersize=5 + 3 * list(marks).index(program), markerfacecolor="none", label=f"{program}, {model}")
    axes.set(xlabel="normal speed of the impact (m/s)", ylabel="coefficient of restitution ε", xscale="log")
    axes.set_xticks(SPEEDS_MPS, [f"{v:g}" for v in SPEEDS_MPS], minor=False)
    axes.xaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    axes.legend(fontsize=8)
    figure.savefig(options.figure, metadata={"Date": None, "Creator": None})


if __name__ == "__main__":
    main()
