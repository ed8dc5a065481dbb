#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables of docs/validation.md: the set of samples/validate.toml scored for builtin and aubioonset in one run.

    python3 tests/bench/validation.py [--program PROGRAM] [--write]     --write puts them into docs/validation.md

Needs aubio-tools and ffmpeg."""
import argparse
import json
import os
import re
import subprocess
import tempfile

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../..")
DETECTORS = ("builtin", "aubioonset -i {wav}")


def number(value, unit=1.0, form="%.3g"):
    return "–" if value is None else form % (value / unit)


def cells(score):
    return [number(score["f_50ms"], form="%.3f"), number(score["f_5ms"], form="%.3f"), number(score["f_1ms"], form="%.3f"),
            number(score["within_drops_s"], 1e-6), number(score["bound_ratio_within_drops"]), number(score["eps_error"], form="%.1e")]


def lines(results):
    yield "| all | detector | F ±50 ms | F ±5 ms | F ±1 ms | jitter, µs | × bound | error of ε | pull | invented an hour | × real time |\n|" + "---|" * 11
    for result in results:
        score = result["all"]
        yield "| %d recordings | `%s` | %s | %s | %s | %s |" % (
            score["n_recordings"], result["detector"], " | ".join(cells(score)), number(score["pull"], form="%.2f"),
            number(score["invented_per_hour"]), number(score["times_real_time"], form="%.0f"))
    yield ""
    yield "| option | value | F ±5 ms | × bound | error of ε | aubio: F ±5 ms | jitter, µs | error of ε |\n|" + "---|" * 8
    ours, other = (result["factors"] for result in results)
    for a, b in zip(ours, other):
        first, second = cells(a["score"]), cells(b["score"])
        yield "| %s | %s | %s | %s | %s | %s | %s | %s |" % (a["option"], a["value"], first[1], first[4], first[5], second[1], second[3], second[5])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=os.path.join(ROOT, "build/release/tools/bouncelab/bouncelab"))
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        command = [options.program, "validate", "--config", os.path.join(ROOT, "samples/validate.toml"), "--out", os.path.join(folder, "v"), "--json"]
        for detector in DETECTORS:
            command += ["--detector", detector]
        results = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)["detectors"]
    text = "\n".join(lines(results))
    if not options.write:
        return print(text)
    path = os.path.join(ROOT, "docs/validation.md")
    with open(path, encoding="utf-8") as file:
        page = file.read()
    with open(path, "w", encoding="utf-8") as file:
        file.write(re.sub(r"(<!-- tests/bench/validation.py -->\n).*?(\n<!-- end -->)", lambda m: m.group(1) + text + m.group(2), page, flags=re.S))


if __name__ == "__main__":
    main()
