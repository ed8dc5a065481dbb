# SPDX-License-Identifier: GPL-3.0-or-later
"""The page of tools/bench: its table, and that it is written whole or not at all. Nothing here asserts a time.

    BOUNCELAB_BUILD=build/release python3 -m unittest test_page      (in tests/bench)
"""
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

from bench_lines import Row, number, seconds

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("BOUNCELAB_BUILD", ROOT / "build" / "release")).resolve()


class Page(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.page = Path(folder.name) / "page.md"

    def bench(self, build):
        return subprocess.run([ROOT / "tools" / "bench", "--quick", "--only", "start", "--programs", build, "--out", self.page],
                              capture_output=True, text=True, check=False)

    def test_a_part_makes_a_page_with_its_rows_and_the_machine(self):
        run = self.bench(BUILD)
        self.assertEqual(run.returncode, 0, run.stderr)
        page = self.page.read_text()
        for what in ("| start over `python3 -c pass` |", "| detect in 12 s of sound over `python3 -c pass` |", "at most 3:", "| processor |", "| compiler |", "quick; start"):
            self.assertIn(what, page)

    def test_a_benchmark_that_fails_leaves_the_page_as_it_was(self):
        self.page.write_text("before\n")
        self.assertNotEqual(self.bench("/nowhere").returncode, 0)
        self.assertEqual(self.page.read_text(), "before\n")
        self.assertEqual([file.name for file in self.page.parent.iterdir()], ["page.md"])

    def test_numbers_have_three_digits_and_units_of_their_size(self):
        self.assertEqual([number(x) for x in (1234.5, 12.345, 9.999, 0.012345)], ["1,230", "12.3", "10.0", "0.0123"])
        self.assertEqual([seconds(x) for x in (61.2, 0.0123, 4.5e-9)], ["61.2 s", "12.3 ms", "4.50 ns"])

    def test_bars_state_what_was_found(self):
        self.assertEqual(Row("what", 2.6, ("at least", 2.5), "how").cells(), ("what", "2.60 ×", "at least 2.5: met", "how"))
        self.assertEqual(Row("what", 1.8, ("at most", 1.7), "how").cells(), ("what", "1.80 ×", "at most 1.7: **missed**", "how"))
        self.assertEqual(Row("what", 8, None, "how").cells(), ("what", "8.00 ×", "", "how"))


if __name__ == "__main__":
    unittest.main()
