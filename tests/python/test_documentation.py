# SPDX-License-Identifier: GPL-3.0-or-later
"""Examples are run, docstrings and types checked."""
import doctest
import importlib
import inspect
import os
import pathlib
import subprocess
import sys
import unittest
import warnings

import bouncelab as bl
from support import Case

MODULES = ["bouncelab", "bouncelab._functions", "bouncelab.notebook", "bouncelab.plot", "bouncelab.progress",
           "bouncelab.results", "bouncelab.stages", "bouncelab.theory"]
FUNCTIONS = ["analyze", "balls", "simulate", "synthesize", "detect", "restitution", "fit", "roughness", "compare", "dem",
             "loop", "eps_of_law", "fluctuation_sides"]
CLASSES = ["Analysis", "Comparison", "Impacts", "Onsets", "Samples", "Recording", "Fit", "Roughness", "Loop"]
PACKAGE = pathlib.Path(bl.__file__).parent


def optional(name):
    try:
        return importlib.import_module(name)
    except ImportError:
        return None


class Examples(Case):
    def test_of_every_docstring(self):
        n = 0
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(self.folder)  # some write files
        for name in MODULES:
            if name == "bouncelab.plot" and optional("matplotlib") is None:
                continue
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", bl.BouncelabWarning)
                found = doctest.testmod(importlib.import_module(name))
            self.assertEqual(found.failed, 0, name)
            n += found.attempted
        self.assertGreater(n, 30)

    def run_block_of_readme(self, word):
        """The first block of the README with this word, in a folder of its own, with `onsets` and `samples` at hand."""
        text = (pathlib.Path(os.environ["BOUNCELAB_NOTEBOOKS"]).parent / "README.md").read_text(encoding="utf-8")
        block = next(part for part in text.split("```python\n")[1:] if word in part.split("```")[0]).split("```")[0]
        names = {"bl": bl, "onsets": bl.detect(os.path.join(os.environ["BOUNCELAB_SAMPLES"], "clean.flac"))}
        names["samples"] = bl.restitution(names["onsets"])
        n_samples = len(names["samples"])
        before = os.getcwd()
        os.chdir(self.folder)
        try:
            exec(block, names)
        finally:
            os.chdir(before)
        return names, n_samples

    @unittest.skipIf(optional("tables") is None, "PyTables is not installed")
    def test_hdf5_by_pandas(self):
        names, n_samples = self.run_block_of_readme("to_hdf")
        self.assertEqual(len(names["samples"]), n_samples)

    @unittest.skipIf(optional("pyarrow") is None, "pyarrow is not installed")
    def test_parquet_by_pandas(self):
        names, n_samples = self.run_block_of_readme("to_parquet")
        self.assertEqual(names["fit"].results["n_used"], n_samples)

    def test_every_function_has_one(self):
        for name in FUNCTIONS:
            self.assertIn(">>> ", getattr(bl, name).__doc__, name)

    def test_everything_public_is_documented(self):
        for name in bl.__all__:
            if name == "plot" and optional("matplotlib") is None:
                continue
            self.assertTrue(inspect.getdoc(getattr(bl, name)), name)
        for name in CLASSES:
            for attribute, value in vars(getattr(bl, name)).items():
                if not attribute.startswith("_") and (inspect.isfunction(value) or isinstance(value, property)):
                    self.assertTrue(inspect.getdoc(value), f"{name}.{attribute}")


class Docstrings(Case):
    # what short docstrings need not have: extended summary, See Also, Examples, a verb in the infinitive, a capital or
    # a period in type lists, Returns of properties, the summary on the line below the quotes; and line breaks (GL01-03)
    NOT_NEEDED = {"ES01", "SA01", "EX01", "SS05", "SS06", "GL01", "GL02", "GL03", "RT03", "GL08", "YD01"}

    @unittest.skipIf(optional("numpydoc") is None, "numpydoc is not installed")
    def test_are_those_of_numpydoc(self):
        from numpydoc.validate import validate

        names = [f"bouncelab.{name}" for name in FUNCTIONS]
        names += [f"bouncelab.{name}" for name in ("Fit.eps", "Fit.sample", "Fit.report", "Onsets.to_csv",
                                                   "Recording.write")]
        if optional("matplotlib") is not None:
            names += ["bouncelab.plot.restitution", "bouncelab.plot.density", "bouncelab.plot.sound"]
        wrong = []
        for name in names:
            wrong += [(name, *error) for error in validate(name)["errors"] if error[0] not in self.NOT_NEEDED]
        self.assertEqual(wrong, [])


class Types(Case):
    @unittest.skipIf(optional("mypy") is None, "mypy is not installed")
    def test_mypy_finds_nothing(self):
        ran = subprocess.run([sys.executable, "-m", "mypy", "--disallow-untyped-defs", "--warn-unused-ignores",
                              "--no-implicit-optional", "--ignore-missing-imports", "--follow-imports=silent",
                              "--cache-dir", self.folder, str(PACKAGE)], capture_output=True, text=True, cwd=self.folder)
        self.assertEqual((ran.stdout.strip().splitlines()[-1].split(":")[0], ran.returncode), ("Success", 0), ran.stdout)

    def test_the_marker_is_there(self):
        self.assertTrue((PACKAGE / "py.typed").exists())

    def test_the_stub_has_the_functions_of_the_module(self):
        stub = (PACKAGE / "_core.pyi").read_text(encoding="utf-8")
        for name, value in vars(bl._core).items():
            if not name.startswith("_") and callable(value):
                self.assertIn(f"def {name}(", stub)


class Import(Case):
    def test_takes_nothing_that_is_not_needed(self):
        script = "import sys, time\nbegin = time.perf_counter()\nimport bouncelab\n" \
                 "print(time.perf_counter() - begin)\nprint(*sys.modules)"
        ran = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True,
                             env=dict(os.environ))
        seconds, modules = ran.stdout.splitlines()
        print(f"import bouncelab: {float(seconds) * 1e3:.0f} ms")
        for slow in ("matplotlib", "pandas", "tqdm", "numpy"):
            self.assertNotIn(slow, modules.split())


if __name__ == "__main__":
    unittest.main()
