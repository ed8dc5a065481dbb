# SPDX-License-Identifier: GPL-3.0-or-later
"""The notebooks run, with small experiments."""
import os
import re
import subprocess
import sys
import unittest

from support import SAMPLES, Case

NOTEBOOKS = os.environ["BOUNCELAB_NOTEBOOKS"]

try:
    import matplotlib
except ImportError:
    matplotlib = None


@unittest.skipIf(matplotlib is None, "Matplotlib is not installed")
class Notebooks(Case):
    def run_notebook(self, name, *words):
        ran = subprocess.run([sys.executable, os.path.join(NOTEBOOKS, name), *words], capture_output=True, text=True,
                             cwd=self.folder, env=dict(os.environ, MPLBACKEND="Agg"))
        self.assertEqual(ran.returncode, 0, ran.stderr)
        return ran.stdout

    def assert_picture(self, name):
        with open(self.path(name), "rb") as file:
            self.assertEqual(file.read(8), b"\x89PNG\r\n\x1a\n")

    def test_my_recording(self):
        said = self.run_notebook("my_recording.py")  # the recording of the repository
        self.assertIn("ε = 0.9", said)
        self.assert_picture("my_recording.png")
        self.assertTrue(os.path.exists(self.path("analysis/report.html")))
        os.mkdir(self.path("mine"))
        self.run_notebook("my_recording.py", os.path.join(SAMPLES, "hard.flac"), "mine")
        self.assertTrue(os.path.exists(self.path("mine/analysis/samples.csv")))

    def test_the_paper(self):
        said = self.run_notebook("paper_in_ten_minutes.py", "6", "50000")
        self.assertRegex(said, r"570 impacts, .* 5[67]\d found")
        told = re.findall(r"(A\d) = .*, 95 %: (\S+) to (\S+); (\S+) went in", said)
        self.assertEqual([name for name, *_ in told], ["A2", "A4", "A5"], said)
        for name, lo, hi, true in told:  # of a ball in air that was not there they lie above
            self.assertTrue(float(lo) < float(true) < float(hi), name)
        self.assert_picture("paper.png")
        self.assertTrue(os.path.exists(self.path("paper.html")))

    def test_the_sweep_agrees_with_the_closed_form(self):
        said = self.run_notebook("roughness_sweep.py", "40", "100000,1000000")
        self.assert_picture("roughness_sweep.png")
        found = re.findall(r"m/s: (\S+) ± (\S+), predicted (\S+?),?\n?(?=,| |$)", said, re.M)
        self.assertEqual(len(found), 6, said)
        for rms, error, predicted in (map(float, row) for row in found):
            # 4 standard errors of 40 drops, given to one digit (hence 5), and 3 % for uniform radii, whose offsets are
            # not exactly normal (docs/physics.md, 7)
            self.assertLess(abs(rms - predicted), 5 * error + 0.03 * predicted, said)


if __name__ == "__main__":
    unittest.main()
