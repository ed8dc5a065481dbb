# SPDX-License-Identifier: GPL-3.0-or-later
"""The page of tools/bench: its sections, and that it is written whole or not at all. Nothing here asserts a time.

    BOUNCELAB_BUILD=build/release python3 -m unittest test_page      (in tests/bench)
"""
import json
import math
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from bench_lines import slope

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("BOUNCELAB_BUILD", ROOT / "build" / "release")).resolve()

sys.path.insert(0, str(ROOT / "tests" / "bench" / "performance"))
from measured import Measured, bar, number, seconds  # noqa: E402
from page import page_of  # noqa: E402


def bench(*words):
    return subprocess.run([ROOT / "tools" / "bench", *map(str, words)], capture_output=True, text=True, check=False)


def headings(page):
    return [line for line in page.splitlines() if line.startswith("## ")]


class Page(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.page = Path(folder.name) / "page.md"

    def test_a_part_makes_a_page_with_its_section_and_the_machine(self):
        run = bench("--quick", "--only", "start-up", "--programs", BUILD, "--out", self.page)
        self.assertEqual(run.returncode, 0, run.stderr)
        page = self.page.read_text()
        self.assertEqual(headings(page), ["## In short", "## The machine", "## 1. Start"])
        for what in ("processor", "cores", "compiler", "bouncelab", "peers", "load at the begin", "load at the end", "python3 -c pass"):
            self.assertIn(what, page)
        lines = [json.loads(line) for line in self.page.with_suffix(".jsonl").read_text().splitlines()]
        for line in lines:
            self.assertEqual(set(line), {"part", "case", "what", "value", "unit"})
        again = self.page.with_name("again.md")
        self.assertEqual(bench("--page-of", self.page.with_suffix(".jsonl"), "--out", again).returncode, 0)
        self.assertEqual(again.read_text(), page)

    def test_a_benchmark_that_fails_leaves_the_page_as_it_was(self):
        self.page.write_text("before\n")
        run = bench("--quick", "--only", "start-up", "--programs", "/nowhere", "--out", self.page)
        self.assertNotEqual(run.returncode, 0)
        self.assertEqual(self.page.read_text(), "before\n")
        self.assertEqual([file.name for file in self.page.parent.iterdir()], ["page.md"])

    def test_a_part_that_was_not_measured_has_no_section(self):
        self.assertEqual(headings(page_of(Measured([]))), ["## The machine"])


class Numbers(unittest.TestCase):
    def test_slope_of_a_power_is_its_exponent_without_error(self):
        by, error = slope([1, 2, 4, 8], [3, 12, 48, 192])
        self.assertAlmostEqual(by, 2, places=12)  # rounding of a few logarithms
        self.assertAlmostEqual(error, 0, places=7)  # root of a sum of squared roundings

    def test_error_of_a_slope_is_that_of_the_textbook(self):
        # residuals (1, -2, 1) / 6 about slope 1/2 of y = 0, 0, 1 at x = 0, 1, 2: sqrt((6/36) / 1 / 2)
        by, error = slope([math.exp(x) for x in (0, 1, 2)], [math.exp(y) for y in (0, 0, 1)])
        self.assertAlmostEqual(by, 0.5, places=12)
        self.assertAlmostEqual(error, math.sqrt(1 / 12), places=12)

    def test_numbers_have_three_digits_and_units_of_their_size(self):
        self.assertEqual([number(x) for x in (1234.5, 12.345, 0.012345, 0)], ["1,230", "12.3", "0.0123", "0"])
        self.assertEqual([seconds(x) for x in (61.2, 0.0123, 4.5e-9)], ["61.2 s", "12.3 ms", "4.50 ns"])

    def test_bars_state_what_was_found(self):
        self.assertEqual(bar(2600, least=2500, unit=" ×"), "at least 2,500 ×: met")
        self.assertEqual(bar(6, most=5, unit=" ms"), "at most 5 ms: **missed**")


if __name__ == "__main__":
    unittest.main()
