# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests of the Python module share."""
import csv
import json
import os
import resource
import subprocess
import tempfile
import unittest

import numpy as np

PROGRAM = os.environ["BOUNCELAB_PROGRAM"]
SAMPLES = os.environ["BOUNCELAB_SAMPLES"]


def argument(value):
    """As it is typed in a shell."""
    return ",".join(map(argument, value)) if isinstance(value, (list, tuple)) else str(value)


def options(keywords):
    """The options of the command line that these keywords are."""
    given = []
    for name, value in keywords.items():
        option = "--" + name.replace("taken_as", "as").replace("_", "-")
        if value is True:
            given.append(option)
        elif isinstance(value, list):
            for item in value:
                given += [option, argument(item)]
        else:
            given += [option, argument(value)]
    return given


def program(command, *words, cwd=None, ok=(0,), **keywords):
    """Runs the program; its standard output."""
    ran = subprocess.run([PROGRAM, command, *words, *options(keywords)], cwd=cwd, capture_output=True, text=True)
    if ran.returncode not in ok:
        raise AssertionError(f"{command} {words} {keywords}: exit code {ran.returncode}\n{ran.stderr}")
    return ran.stdout


def printed(command, *words, **keywords):
    """What the program prints with --json."""
    return json.loads(program(command, *words, "--json", **keywords))


def read(path):
    with open(path, encoding="utf-8", newline="") as file:
        return file.read()


def columns_of_csv(path):
    """Cells as texts, by column."""
    with open(path, encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    return {name: [row[k] for row in rows[1:]] for k, name in enumerate(rows[0])}


def small_impacts(bl, **keywords):
    return bl.simulate(**dict(dict(drops=6, impacts=30, asperities=20000), **keywords))


def small_sound(bl, impacts=None, **keywords):
    impacts = small_impacts(bl) if impacts is None else impacts
    return bl.synthesize(impacts, **dict(dict(rate=22050, max_mode=10000), **keywords))


def peak_memory():
    """The most that this process has held [bytes]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def memory():
    """What it holds now [bytes]."""
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * resource.getpagesize()


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="bouncelab-test-")
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def assert_same_columns(self, columns, path):
        """Every number and text of the table, the file's cells read by Python's own float()."""
        cells = columns_of_csv(path)
        self.assertEqual(list(columns), list(cells))
        for name, texts in cells.items():
            found = columns[name]
            self.assertEqual(len(found), len(texts), name)
            if found.dtype.kind == "O":
                self.assertEqual(list(found), texts, name)
            elif found.dtype.kind == "i":
                self.assertEqual(found.tolist(), [int(text) for text in texts], name)
            else:
                self.assertEqual(found.dtype, np.float64, name)
                expected = np.array([float(text) if text else np.nan for text in texts])
                np.testing.assert_array_equal(found.view(np.uint64)[~np.isnan(found)],
                                              expected.view(np.uint64)[~np.isnan(expected)], name)
                np.testing.assert_array_equal(np.isnan(found), np.isnan(expected), name)
