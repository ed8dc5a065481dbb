# SPDX-License-Identifier: GPL-3.0-or-later
"""Keywords are the options of the command line; what is wrong is said as there, as Python's own errors."""
import errno
import inspect
import os
import pathlib
import re
import unittest
import warnings

import bouncelab as bl
import numpy as np
from support import Case, program, small_impacts, small_sound

# options that only choose how the program prints, or that are other things in Python: files of results are written by
# the results, a file of options is a dict, several samples are one table, parts of a run are processes of the program
NOT_IN_PYTHON = {"help", "json", "quiet", "config", "out", "labels", "force", "list"}
NOT_IN = {"simulate": {"write_surface"}, "synthesize": {"truth", "each_drop", "codec"},
          "fit": {"table", "histograms", "slopes", "columns"}, "roughness": {"columns"},
          # that draws no random numbers; from_csv takes what files are
          "restitution": {"seed", "threads", "as", "columns", "tier"}, "dem": {"seed", "threads"}}
IN_PYTHON = {"progress", "name"}
COMMANDS = ["analyze", "simulate", "synthesize", "detect", "restitution", "fit", "roughness", "compare", "dem", "loop"]


class Keywords(Case):
    def test_names_are_those_of_the_help(self):
        for command in COMMANDS:
            text = program(command, "--help-all")
            names = {name.replace("-", "_") for name in re.findall(r"^  (?:-\w )?--([a-z-]+)", text, re.M)}
            names -= NOT_IN_PYTHON | NOT_IN.get(command, set())
            if command in ("analyze", "compare", "loop"):
                names |= {"out", "force"}
            if "as" in names:  # a word of Python
                names = names - {"as"} | {"taken_as"}
            found = inspect.signature(getattr(bl, command)).parameters
            keywords = {p.name for p in found.values() if p.kind == p.KEYWORD_ONLY}
            if command == "detect":  # a number beside the array
                keywords.add("rate")
            self.assertGreater(len(names), 2, command)
            self.assertEqual(keywords - IN_PYTHON, names, command)

    def test_every_keyword_is_documented_with_the_help_s_words(self):
        for command in COMMANDS:
            function = getattr(bl, command)
            for name in inspect.signature(function).parameters:
                self.assertRegex(function.__doc__, rf"(?m)^    {name} : ")
        self.assertIn("Fall height [m]: one value, or LO,HI to draw between; 1e-06 to 1000.", bl.simulate.__doc__)

    def test_unknown_keywords(self):
        for command in COMMANDS:
            with self.assertRaisesRegex(TypeError, "dropps"):
                getattr(bl, command)(*([None] if "array" in str(command) else []), dropps=3)

    def test_ranges_and_names_as_the_program_says_them(self):
        for keywords, message in [
                (dict(drops=0), "drops: '0' must be a decimal integer from 1 to 1000000000"),
                (dict(drops=1.5), "drops: '1.5' must be a decimal integer"),
                (dict(height=-1.0), "height: "),
                (dict(beta=float("nan")), "beta: 'nan' must be a finite decimal number"),
                (dict(contact="papr"), "contact: "),
                (dict(ball="stel"), "did you mean steel"),
                (dict(law="series:A2"), "law"),
                (dict(spin=(1, 2)), "spin: "),
                (dict(seed=-1), "seed: "),
                (dict(drops="many"), "drops: 'many'"),
                (dict(drops=True), "drops: "),
        ]:
            with self.subTest(keywords), self.assertRaisesRegex(ValueError, re.escape(message)):
                bl.simulate(**keywords)

    def test_numbers_of_numpy_texts_and_paths(self):
        expected = small_impacts(bl, drops=2, height=0.1, spin=(1, 0, 0.5), seed=3)
        for keywords in [dict(drops=np.int64(2), height=np.float64(0.1), spin=np.array([1, 0, 0.5]), seed=np.uint8(3)),
                         dict(drops="2", height="0.1", spin="1,0,0.5", seed="3"),
                         dict(drops=2, height=[0.1], spin=[np.float32(1), 0, 0.5], seed=3),
                         dict(drops=2e0, height=iter([0.1]), spin=(x for x in (1, 0, 0.5)), seed=3.0, drag=np.False_)]:
            found = small_impacts(bl, **keywords)
            np.testing.assert_array_equal(found.v, expected.v)
        found = bl.fit(bl.Samples(v=expected.v, eps=expected.eps), nodes=np.array([0.8, 1.1]), goodness_replicates=0,
                       orders=2)
        self.assertEqual((list(found.nodes), list(found.parameters)), ([0.8, 1.1], ["A2"]))

    def test_none_and_false_leave_the_default(self):
        np.testing.assert_array_equal(small_impacts(bl, drops=2, ball=None, drag=False).v,
                                      small_impacts(bl, drops=2).v)


class Errors(Case):
    def setUp(self):
        super().setUp()
        self.onsets = bl.Onsets(t=[0.0, 1.0, 1.9, 2.71])

    def written(self, text):
        path = self.path("there.csv")
        with open(path, "w", encoding="ascii") as file:
            file.write(text)
        return path

    def test_files(self):
        here = self.written("t_s\n1\nx\n")
        for call in [lambda: bl.detect("/nonexistent.wav"), lambda: bl.detect(["/none.wav", "/nonexistent.wav"]),
                     lambda: bl.restitution("/nonexistent.csv"), lambda: bl.restitution(here),
                     lambda: self.onsets.to_csv("/dev/null/x.csv"), lambda: bl.Fit.from_json("/nonexistent.json"),
                     lambda: bl.simulate(surface="/nonexistent.csv")]:
            with self.assertRaises(OSError):
                call()
        with self.assertRaisesRegex(OSError, "row 2|line 3"):
            bl.restitution(pathlib.Path(here))

    def test_files_that_are_not_there_are_folders_or_may_not_be_read(self):
        takers = [bl.detect, bl.restitution, bl.fit, bl.roughness, bl.synthesize, bl.analyze, bl.compare, bl.dem,
                  bl.Onsets.from_csv, bl.Samples.from_csv, bl.Impacts.from_csv, lambda name: bl.detect([name, name + "x"]),
                  lambda name: bl.analyze([name, name + "x"]), lambda name: bl.fit(self.samples(), groups=name)]
        closed = self.written("t_s,v_mps,eps\n1,1,1\n")
        os.chmod(closed, 0)
        for name, kind, number in [(self.path("none.csv"), FileNotFoundError, errno.ENOENT), ("", FileNotFoundError, errno.ENOENT),
                                   (self.folder, IsADirectoryError, errno.EISDIR), (closed, PermissionError, errno.EACCES)]:
            if kind is PermissionError and os.geteuid() == 0:
                continue  # root may read all
            for k, take in enumerate(takers if name else takers[:-1]):  # no groups: an empty name
                with self.subTest(name=name, k=k), self.assertRaises(kind) as raised:
                    take(name)
                self.assertEqual(raised.exception.errno, number)
                if name:
                    self.assertEqual(raised.exception.filename, name)

    def samples(self):
        return bl.Samples(v=[1.0, 0.9], eps=[0.9, 0.9])

    def test_words_of_the_command_line_are_keywords(self):
        for said, words in [("(--min-impacts takes shorter drops)", "(min_impacts= takes shorter drops)"),
                            ("--unit furlong: heights", "unit='furlong': heights"), ("use --pool or --ball", "use pool=True or ball="),
                            ("say --as heights --unit cm.", "say taken_as='heights', unit='cm'."), ("--nodes: 'x' must", "nodes: 'x' must"),
                            ("--columns v=COLUMN,eps=COLUMN or", "columns='v=COLUMN,eps=COLUMN' or"), ("--rate 48000)", "rate=48000)"),
                            ("bouncelab --nothing", "bouncelab --nothing"), ("a--ball.wav", "a--ball.wav"), ("", "")]:
            self.assertEqual(bl._core.with_keywords(said), words)

    def test_what_holds_nothing(self):
        for function in (bl.detect, bl.analyze, bl.compare):
            for nothing in ([], ()):
                with self.subTest(function), self.assertRaisesRegex(ValueError, "^no (recording is|samples are) given"):
                    function(nothing)
        with self.assertRaisesRegex(TypeError, "vary: 'snr' is no keyword"):
            bl.validate(lambda x, rate: [], vary={"snr": [30]})
        with self.assertRaisesRegex(TypeError, "int given; a detector is a function"):
            bl.validate(5)
        with self.assertRaisesRegex(TypeError, "the detector gave NoneType; times"):
            bl.validate(lambda x, rate: None, drops=1, impacts=3, asperities=100, rate=22050, max_mode=10000)
        with self.assertRaisesRegex(TypeError, "detect\\(samples, rate\\)"):
            bl.detect({})
        with self.assertRaisesRegex(TypeError, "law: NoneType"):
            bl.eps_of_law(None, 1.0)

    def test_a_table_that_does_not_prove_what_it_holds_is_asked_with_its_answers(self):
        with self.assertRaisesRegex(ValueError, "columns='v=COLUMN,eps=COLUMN'"):
            bl.Samples.from_csv(self.written("t_s\n1\n2\n"))
        falling = self.written("0.6\n0.51\n0.4335\n")
        with self.assertRaisesRegex(ValueError, "do not rise.*; say .*taken_as='intervals', unit='s'"):
            bl.Onsets.from_csv(falling)
        onsets = bl.Onsets.from_csv(falling, taken_as="intervals", unit="s")
        np.testing.assert_allclose(onsets.t, [0.0, 0.6, 1.11, 1.5435])

    def test_one_of_several_recordings_that_cannot_be_read_is_left_out(self):
        small_sound(bl, small_impacts(bl, drops=1)).write(self.path("s.wav"))
        with self.assertWarnsRegex(bl.BouncelabWarning, "/nonexistent.wav: no such file.*left out"):
            onsets = bl.detect(["/nonexistent.wav", self.path("s.wav")])
        self.assertEqual(len(onsets), 30)

    def test_analyze_takes_files_and_says_why_there_is_no_answer(self):
        sound = small_sound(bl, small_impacts(bl, drops=1))
        for given in (sound, sound.samples, self.onsets, [self.onsets]):
            with self.assertRaisesRegex(TypeError, r"takes files, \w+ is given; .*fit\(restitution\(detect\("):
                bl.analyze(given)
        with self.assertRaisesRegex(FileNotFoundError, "no such file.*nonexistent.wav"):
            bl.analyze("/nonexistent.wav", out=self.path("out"))
        bl.Recording(np.zeros(50000, np.float32), 44100, name="", truth=self.onsets, others={}, bits="16").write(
            self.path("silent.wav"))
        with self.assertRaisesRegex(ValueError, "silent.wav: no sound is louder than the noise"):
            bl.analyze(self.path("silent.wav"), out=self.path("out"))
        with self.assertRaisesRegex(ValueError, "no three successive impacts"):
            bl.analyze(self.written("t_s\n0\n1\n"), out=self.path("out"))
        self.assertFalse(os.path.exists(self.path("out")))
        falling = self.written("0.6\n0.51\n0.4335\n")
        with self.assertRaisesRegex(ValueError, r"; say .*analyze\(path, taken_as='intervals', unit='s'\)"):
            bl.analyze(falling)
        analysis = bl.analyze(falling, taken_as="intervals", unit="s")
        self.assertEqual((len(analysis.onsets), len(analysis.samples), len(analysis.fit.samples)), (4, 2, 2))

    def test_what_cannot_be_compared(self):
        few = bl.Samples(v=[1.0, 0.9], eps=[0.9, 0.9])
        with self.assertWarnsRegex(bl.BouncelabWarning, "1 has 2 usable samples"):
            comparison = bl.compare([few, few])
        self.assertEqual((comparison.differences, [row["eps"] for row in comparison.recordings]), ([], [None, None]))
        with self.assertRaisesRegex(TypeError, "int given"):
            bl.compare([few, 3])
        with self.assertRaises(OSError):
            bl.compare("/nonexistent.csv")

    def test_what_no_code_can_take(self):
        fit = bl.fit(bl.Samples(v=small_impacts(bl).v, eps=small_impacts(bl).eps), goodness_replicates=0)
        with self.assertRaisesRegex(ValueError, "fit: nothing memory for lammps: it has constant"):
            bl.dem(fit, model="memory")
        with self.assertRaisesRegex(ValueError, "^code: "):
            bl.dem(fit, code="lamps")
        with self.assertRaises(OSError):
            bl.dem("/nonexistent.json")

    def test_files_that_exist_are_kept(self):
        out = self.path("o.csv")
        self.onsets.to_csv(out)
        before = os.stat(out).st_mtime_ns
        with self.assertRaisesRegex(FileExistsError, "force=True replaces it"):
            bl.restitution(self.onsets).to_csv(out)
        self.assertEqual(os.stat(out).st_mtime_ns, before)
        bl.restitution(self.onsets).to_csv(out, force=True)
        self.assertEqual(len(bl.Samples.from_csv(out)), 2)

    def test_a_loop_in_a_folder_that_exists(self):
        os.mkdir(self.path("loop"))
        with open(self.path("loop/fit.json"), "w", encoding="ascii") as file:
            file.write("mine")
        with self.assertRaises(FileExistsError):
            bl.loop(out=self.path("loop"), drops=2, impacts=12, asperities=1000)
        with open(self.path("loop/fit.json"), encoding="ascii") as file:
            self.assertEqual(file.read(), "mine")

    def test_impacts_are_no_samples(self):
        impacts, file = small_impacts(bl, drops=1), self.path("i.csv")
        impacts.to_csv(file)
        for given in (impacts, impacts.to_dict()):
            with self.assertRaisesRegex(TypeError, r"restitution\(impacts\)"):
                bl.fit(given)
        with self.assertRaisesRegex(OSError, "make them first: bouncelab restitution"):
            bl.fit(file)

    def test_times_that_fall(self):
        with self.assertRaisesRegex(ValueError, r"are these intervals \(numpy.cumsum.* makes times of them\)"):
            bl.restitution({"t_s": [3.0, 2.0, 1.0]})
        for text in ("t_s\n3\n2\n1\n", "drop,impact,t_s\n0,0,3\n0,1,2\n0,2,1\n"):
            with self.assertRaisesRegex((OSError, ValueError), r"Onsets.from_csv\(path, taken_as='intervals'\)"):
                bl.restitution(self.written(text))

    def test_tables_in_memory_are_not_called_as_files(self):
        samples = bl.restitution(small_impacts(bl, drops=8))  # the column recording is empty
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            comparison = bl.compare([samples, samples])
            bl.compare(samples)
        self.assertEqual([row["recording"] for row in comparison.recordings], ["1", "2"])
        self.assertIn("table 1: 1 of 1 recording", "".join(str(one.message) for one in told))
        self.assertNotIn(".csv", "".join(str(one.message) for one in told))

    def test_what_cannot_be_fitted(self):
        with self.assertRaisesRegex(ValueError, "no three successive impacts"):
            bl.restitution(bl.Onsets(t=[0.0, 1.0]))
        for function in (bl.fit, bl.roughness):
            with self.assertRaisesRegex(TypeError, "int given"):
                function(3)
            with self.assertRaisesRegex(ValueError, "eps|v_mps"):
                function(bl.Samples())
        few = bl.fit(bl.Samples(v=[1.0, 0.9], eps=[0.9, 0.9]))
        self.assertNotIn(few.status, ("ok", "not_identifiable"))
        found = few.eps(1.0)  # of two bounces, by what such balls do
        self.assertTrue(0 < found.lo95 < 0.9 < found.hi95 < 1)
        for use in (lambda: few.sample(1.0), lambda: few.law_text):
            with self.assertRaisesRegex(ValueError, few.status):
                use()
        self.assertIn("Fit", repr(few))
        self.assertIn("<p>", few._repr_html_())

    def test_sound_without_a_rate(self):
        with self.assertRaisesRegex(ValueError, "rate is missing"):
            bl.detect(np.zeros(1000, np.float32))
        for rate in (0, -1, 100, 1e9, float("nan"), float("inf")):
            with self.subTest(rate), self.assertRaises(ValueError):
                bl.detect(np.zeros(1000, np.float32), rate)

    def test_warnings_of_the_program_are_warnings(self):
        with self.assertWarnsRegex(bl.BouncelabWarning, "drops ended early"):
            bl.simulate(drops=2, impacts=10, asperities=2000, plate_size=(0.05, 0.05), spin=(0, 50, 0))
        with self.assertWarnsRegex(bl.BouncelabWarning, "ε below 0 or above 1") as seen:
            bl.fit(bl.Samples(v=small_impacts(bl).v, eps=small_impacts(bl).eps + 0.2), goodness_replicates=0)
        self.assertEqual(os.path.basename(seen.filename), "test_arguments.py")  # of the caller, not of the package

    def test_unknown_columns_and_attributes(self):
        with self.assertRaisesRegex(TypeError, "no column 'tt'"):
            bl.Onsets(tt=[1])
        with self.assertRaises(AttributeError):
            self.onsets.times
        with self.assertRaisesRegex(KeyError, "'tt': no such column; there are .*t_s"):
            self.onsets["tt"]
        with self.assertRaisesRegex(AttributeError, "no column sigma_t_s"):
            self.onsets.sigma
        with self.assertRaises(AttributeError):
            bl.nothing
        with self.assertRaisesRegex(OSError, "."):
            small_sound(bl, small_impacts(bl, drops=1)).write("/dev/null/s.wav")


if __name__ == "__main__":
    unittest.main()
