# SPDX-License-Identifier: GPL-3.0-or-later
"""What results can do: intervals, draws, tables, reports, pictures."""
import copy
import json
import os
import unittest
import warnings

import bouncelab as bl
import numpy as np
from support import SAMPLES, Case, read, small_impacts, small_sound

try:
    import pandas
except ImportError:
    pandas = None
try:
    import matplotlib
except ImportError:
    matplotlib = None


def fitted():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", bl.BouncelabWarning)
        onsets = bl.detect(small_sound(bl, small_impacts(bl, drops=12, asperities=100000)))
        return bl.fit(bl.restitution(onsets), goodness_replicates=9)


class FitResults(Case):
    @classmethod
    def setUpClass(cls):
        cls.fit = fitted()

    def test_the_curve_at_its_points_is_that_of_fit_json(self):
        points = self.fit.results["curve"]["points"]
        found = self.fit.eps([p["v_mps"] for p in points])
        self.assertGreater(len(points), 5)
        for name, values in (("eps", found.value), ("lo95", found.lo95), ("hi95", found.hi95)):
            # ln v of the points is computed twice: some units in the last place
            np.testing.assert_allclose(values, [p[name] for p in points], rtol=1e-14)
        for speed, node in self.fit.nodes.items():
            value = self.fit.eps(speed)
            # between two of 41 points the curve is straight: a smooth one is off by much less than its error
            self.assertAlmostEqual(value.value, node.value, delta=0.1 * node.se)
            self.assertLess(value.lo95, node.value)
            self.assertGreater(value.hi95, node.value)

    def test_what_went_names_what_took_its_place(self):
        with self.assertRaisesRegex(AttributeError, "results..constants.."):
            self.fit.law
        with self.assertRaisesRegex(AttributeError, "no attribute 'lwa'"):
            self.fit.lwa

    def test_shapes_of_speeds(self):
        self.assertIsInstance(self.fit.eps(0.8).value, float)
        self.assertEqual(self.fit.eps(np.full((2, 3), 0.8)).se.shape, (2, 3))
        self.assertEqual(self.fit.eps([]).value.shape, (0,))
        outside = self.fit.eps([1e-3, 100.0])
        self.assertTrue(np.isnan(outside.value).all() and np.isnan(outside.lo95).all())
        for bad in (0, -1, np.nan, np.inf, [1.0, 0.0]):
            with self.assertRaisesRegex(ValueError, "finite and > 0"):
                self.fit.eps(bad)
            with self.assertRaisesRegex(ValueError, "finite and > 0"):
                self.fit.sample(bad)

    def test_draws_have_the_fitted_distribution(self):
        """Kolmogorov-Smirnov against the normal-Laplace distribution (Reed & Jorgensen 2004), from its own formula."""
        n = 40000
        for v in (0.8, 1.2):
            drawn = np.sort(self.fit.sample(v, n, np.random.default_rng(20)))
            below, above, normal, _ = self.scatter(v)
            spread = np.sqrt(below**2 + above**2 + normal**2)
            rms = self.fit.eps(v).value
            mean = np.sqrt(rms**2 - spread**2)
            centre = mean - (above - below)  # of the two exponentials' joint
            cdf = normal_laplace(drawn - centre, below, above, normal)
            ks = max(np.max(cdf - np.arange(n) / n), np.max(np.arange(1, n + 1) / n - cdf))
            self.assertLess(ks, 1.95 / np.sqrt(n))  # exceeded with probability 1e-3 (Kolmogorov's limit), seed fixed
            self.assertLess(abs(drawn.mean() - mean), 4 * spread / np.sqrt(n))
            self.assertLess(abs(np.sqrt(np.mean(drawn**2)) - rms), 4 * spread / np.sqrt(n))
            self.assertLess(abs(drawn.std() / spread - 1), 4 * np.sqrt(5 / (4 * n)))  # kurtosis at most 6
        # beyond the data the draws are those at the end
        fastest = self.fit.results["curve"]["points"][-1]["v_mps"]
        draw = lambda v: self.fit.sample(v, 5, np.random.default_rng(3))  # noqa: E731
        np.testing.assert_allclose(draw(100.0), draw(fastest), rtol=1e-12)

    def scatter(self, v):
        model = self.fit.results["scatter"]
        return (float(x) for x in bl._core.scatter(model["v_ref_mps"], model["log_below"], model["log_above"],
                                                   model["normal_ratio"], np.array(v)))

    def test_draws_are_those_of_the_generator(self):
        draw = lambda seed, *shape: self.fit.sample(*shape, rng=np.random.default_rng(seed))  # noqa: E731
        np.testing.assert_array_equal(draw(1, 0.8, 5), draw(1, 0.8, 5))
        self.assertFalse((draw(1, 0.8, 5) == draw(2, 0.8, 5)).any())
        self.assertEqual(draw(1, [0.8, 0.9], 3).shape, (3, 2))
        self.assertEqual(draw(1, [0.8, 0.9]).shape, (2,))
        self.assertEqual(np.ndim(draw(1, 0.8)), 0)
        self.assertFalse((self.fit.sample(0.8, 3) == self.fit.sample(0.8, 3)).any())

    def test_the_law_goes_on_as_an_option(self):
        impacts = bl.simulate(drops=1, impacts=5, asperities=1, law=self.fit.law_text, min_speed=0.2)
        np.testing.assert_allclose(impacts.eps_contact, bl.eps_of_law(self.fit.law_text, impacts.v_contact), rtol=1e-12)

    def test_estimates(self):
        for name, found in self.fit.parameters.items():
            self.assertEqual(found.value, self.fit.results["constants"][name]["value"])
            self.assertEqual([found.lo95, found.hi95], self.fit.results["constants"][name]["ci95"])

    def test_a_fit_of_an_earlier_version_is_refused(self):
        old = {key: value for key, value in self.fit.results.items() if key != "scatter"}
        with open(self.path("old.json"), "w", encoding="utf-8") as file:
            json.dump(old, file)
        with self.assertRaisesRegex(ValueError, "old.json: .*0.2.*bouncelab fit samples.csv"):
            bl.Fit.from_json(self.path("old.json"))

    def test_constants_of_a_law_that_does_not_hold_are_not_stated(self):
        results = json.loads(self.fit._text)
        results["notes"] = [{"kind": "law_contradicted", "severity": "detail", "text": "off"}]
        results["constants"] = {"status": "not_applicable", "with_memory": False, "parameters": [],
                                "covariance": [], "gamma": None}
        fit = bl.Fit(json.dumps(results))
        self.assertEqual(fit.parameters, {})
        self.assertEqual(fit.eps(0.8), self.fit.eps(0.8))
        with self.assertRaisesRegex(ValueError, "off"):
            fit.law_text

    def test_a_report_is_written_whole_or_not_at_all(self):
        out = self.path("r.html")
        self.fit.report(out, title="Drop & <tests>")
        text = read(out)
        self.assertIn("Drop &amp; &lt;tests&gt;", text)
        self.assertTrue(text.rstrip().endswith("</html>"))
        self.assertEqual([name for name in os.listdir(self.folder) if name.endswith(".html")], ["r.html"])
        with self.assertRaises(FileExistsError):
            self.fit.report(out)
        self.assertEqual(read(out), text)
        self.fit.report(out, force=True)
        self.assertNotEqual(read(out), text)
        with self.assertRaises(OSError):
            self.fit.report(os.path.join(out, "r.html"))
        bl.Fit(self.fit._text).report(self.path("alone.html"))  # without samples and sound

    def test_texts(self):
        self.assertIn(self.fit.status, repr(self.fit))
        self.assertIn("ε", self.fit.answer)
        self.assertEqual(self.fit.to_dict(), json.loads(self.fit._text))

    @unittest.skipIf(pandas is None, "pandas is not installed")
    def test_a_table_of_the_fit(self):
        table = self.fit.to_pandas()
        self.assertEqual(list(table.columns), ["value", "se", "lo95", "hi95"])
        self.assertEqual(table.loc["A2", "value"], self.fit.parameters["A2"].value)


def normal_laplace(x, below, above, normal):
    """Distribution function of a normal number plus an exponential one above less one below, by quadrature."""
    # E[F_L(x - normal z)] over z normal; F_L of the asymmetric Laplace. Gauss-Hermite of 80 nodes where the exponential
    # sides are wider than the normal part; a grid of 4,001 points otherwise: the same, and exact to 1e-6 for both
    z = np.linspace(-8, 8, 4001)
    weights = np.exp(-z * z / 2)
    weights /= weights.sum()
    points = np.linspace(x.min() - 1e-12, x.max() + 1e-12, 2001)
    at = points[:, None] - normal * z
    share = below / (below + above)
    laplace = np.where(at < 0, share * np.exp(np.minimum(at, 0) / below),
                       1 - (1 - share) * np.exp(-np.maximum(at, 0) / above))
    return np.interp(x, points, laplace @ weights)


def of_recordings():
    """Three recordings of balls that differ, of the first two there are two drops."""
    tables = []
    for name, law, seed, drops in (("a.wav", "constant:0.97", 1, 2), ("b.wav", "constant:0.95", 2, 2), ("c.wav", "constant:0.95", 3, 1)):
        impacts = small_impacts(bl, drops=drops, law=law, seed=seed)
        tables.append({"recording": np.array([name] * len(impacts), object), "drop": impacts.drop, "impact": impacts.impact,
                       "v": impacts.v, "eps": impacts.eps})
    return bl.Samples({name: np.concatenate([table[name] for table in tables]) for name in tables[0]})


class Recordings(Case):
    @classmethod
    def setUpClass(cls):
        cls.samples = of_recordings()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", bl.BouncelabWarning)
            cls.fit = bl.fit(cls.samples, goodness_replicates=0, nodes=[0.8, 1.1])
            cls.plates = bl.fit(cls.samples, groups={"a.wav": "A", "b.wav": "B", "c.wav": "B"}, goodness_replicates=0)

    def setUp(self):
        super().setUp()
        warnings.simplefilter("ignore", bl.BouncelabWarning)
        self.addCleanup(warnings.resetwarnings)

    def test_a_row_each(self):
        rows = self.fit.recordings
        self.assertEqual([row["recording"] for row in rows], ["a.wav", "b.wav", "c.wav"])
        self.assertEqual([row["n_drops"] for row in rows], [2, 2, 1])
        for row, answer in zip(rows, self.fit.results["answer"]["recordings"]):
            self.assertEqual((row["eps"], [row["lo95"], row["hi95"]]), (answer["at"]["eps"], answer["at"]["ci95"]))
            self.assertEqual(list(row), ["recording", "v_mps", "eps", "se", "lo95", "hi95", "n", "n_drops", "missing"])

    def test_one_recording_has_a_row_too(self):
        alone = bl.fit(self.samples[self.samples.recording == "c.wav"], goodness_replicates=0)
        row, = alone.recordings
        self.assertEqual((row["recording"], row["n"], row["eps"]), ("c.wav", 30, alone.results["answer"]["at"]["eps"]))
        self.assertIs(alone.of("c.wav"), alone)
        few, = bl.fit(bl.Samples(v=[np.nan], eps=[0.9])).recordings
        self.assertTrue(np.isnan(few["eps"]) and few["missing"])

    def test_the_fit_of_one_is_that_of_its_samples_alone(self):
        found = self.fit.of("b.wav")
        alone = bl.fit(self.samples[30 * 2:30 * 4], goodness_replicates=0, nodes=[0.8, 1.1])
        self.assertEqual(found.results, alone.results)
        row = self.fit.results["recordings"][1]
        self.assertEqual([found.nodes[node["v_mps"]].value for node in row["nodes"]], [node["eps"] for node in row["nodes"]])
        with self.assertRaisesRegex(KeyError, "'d.wav': the fit is of 'a.wav', 'b.wav', 'c.wav'"):
            self.fit.of("d.wav")
        with self.assertRaisesRegex(ValueError, "samples are needed"):
            bl.Fit(self.fit._text).of("a.wav")

    def test_plates(self):
        self.assertEqual([row["recording"] for row in self.plates.recordings], ["A", "B"])
        found = self.plates.of("B")
        self.assertEqual(found.results["n_used"], 90)
        self.assertEqual([row["recording"] for row in found.recordings], ["b.wav", "c.wav"])
        columns = {"recording": ["a.wav", "b.wav", "c.wav"], "plate": ["A", "B", "B"]}
        for groups in [columns] + ([pandas.DataFrame(columns)] if pandas is not None else []):
            self.assertEqual(bl.fit(self.samples, groups=groups, goodness_replicates=0).results, self.plates.results)
        with self.assertRaisesRegex(TypeError, "int given; groups is a table"):
            bl.fit(self.samples, groups=3)

    def test_a_comparison_takes_plates_in_memory_too(self):
        comparison = bl.compare(self.samples, groups={"a.wav": "A", "b.wav": "B", "c.wav": "B"})
        self.assertEqual([row["plate"] for row in comparison.recordings], ["A", "B", "B"])

    @unittest.skipIf(pandas is None, "pandas is not installed")
    def test_pandas_makes_a_table_of_them(self):
        self.assertEqual(pandas.DataFrame(self.fit.recordings).shape, (3, 9))


class Tables(Case):
    @classmethod
    def setUpClass(cls):
        cls.onsets = bl.detect(small_sound(bl))
        cls.samples = bl.restitution(cls.onsets)

    def test_they_are_mappings(self):
        self.assertEqual(list(self.onsets), list(self.onsets.to_dict()))
        self.assertIs(self.onsets["t"], self.onsets["t_s"])
        self.assertIs(self.onsets.t, self.onsets.to_dict()["t_s"])  # no copy
        self.assertIn("t", dir(self.onsets))
        self.assertEqual(len(self.onsets), len(self.onsets.t))
        with self.assertRaises(KeyError):
            self.onsets["nothing"]
        again = bl.restitution(self.onsets.to_dict())
        np.testing.assert_array_equal(again.eps, self.samples.eps)

    def test_a_column_that_is_assigned_is_refused_and_the_remedies_work(self):
        samples = bl.Samples(v=[1.0, 0.9], eps=[0.9, 0.8])
        for name in ("eps", "sigma", "v_mps"):  # also one that is not there, and a long name
            with self.assertRaisesRegex(AttributeError, rf"table\['{name}'\]\[:\] = .*Samples\({{\*\*table, '{name}': "):
                setattr(samples, name, [0.5, 0.4])
        another = bl.Samples({**samples, "eps": [0.5, 0.4]}, world=samples.world)
        samples["eps"][:] = [0.5, 0.4]
        self.assertEqual(samples, another)
        self.assertEqual(list(another.eps), [0.5, 0.4])

    def test_rows(self):
        for rows in (slice(5), slice(None, None, 30), self.onsets.drop == 2, [3, 1], np.array([], int)):
            some = self.onsets[rows]
            self.assertIs(type(some), bl.Onsets)
            for name, values in self.onsets.items():
                np.testing.assert_array_equal(some[name], values[rows])
        with self.assertRaisesRegex(KeyError, "3: the name of a column, a slice or a mask"):
            self.onsets[3]

    def test_equality(self):
        self.assertEqual(self.onsets, copy.deepcopy(self.onsets))
        self.assertNotEqual(self.onsets, self.onsets[1:])
        self.assertNotEqual(self.onsets, self.samples)
        self.assertNotEqual(self.onsets, 3)

    def test_short_names_in_a_dict(self):
        self.assertEqual(list(bl.Samples.of({"v": [1.0], "eps": [0.9]})), ["v_mps", "eps"])

    def test_one_row_is_one_row(self):
        self.assertRegex(repr(self.onsets[:1]), "Onsets: 1 row of recording, ")

    def test_an_analysis_stands_for_its_samples_and_its_fit(self):
        analysis = bl.analyze(os.path.join(SAMPLES, "clean.flac"))
        self.assertEqual(bl.fit(analysis).results["n_used"], len(analysis.samples))
        self.assertEqual(bl.dem(analysis, code="lammps"), bl.dem(analysis.fit, code="lammps"))

    def test_what_is_temporary_goes_without_a_warning(self):
        with warnings.catch_warnings():
            warnings.simplefilter("error", ResourceWarning)
            with self.assertRaises(FileNotFoundError):
                bl.analyze("/nonexistent.wav")
            analysis = bl.analyze(os.path.join(SAMPLES, "clean.flac"))
            folder = analysis.folder
            del analysis
        self.assertFalse(os.path.exists(folder))

    def test_pickles_and_copies(self):
        import pickle

        for table in (self.onsets, self.samples, small_impacts(bl, drops=1)):
            for again in (pickle.loads(pickle.dumps(table)), copy.deepcopy(table), copy.copy(table)):
                self.assertEqual(type(again), type(table))
                for name in table:
                    np.testing.assert_array_equal(again[name], table[name])

    @unittest.skipIf(pandas is None, "pandas is not installed")
    def test_round_trip_through_pandas(self):
        frame = self.onsets.to_pandas()
        self.assertEqual(list(frame.columns), list(self.onsets))
        self.assertEqual(len(frame), len(self.onsets))
        np.testing.assert_array_equal(bl.restitution(frame).eps, self.samples.eps)
        first = frame[frame["drop"] == 0]  # an index that has holes, columns that are views
        self.assertEqual(len(bl.restitution(first)), 28)
        both = pandas.concat([self.samples.to_pandas(), self.samples.to_pandas().assign(recording="another")])
        self.assertEqual(bl.fit(both, goodness_replicates=0).results["n_used"], 2 * len(self.samples))
        frame.to_csv(self.path("pandas.csv"), index=False)
        np.testing.assert_array_equal(bl.restitution(self.path("pandas.csv")).eps, self.samples.eps)

    def test_a_table_comes_back_from_its_file(self):
        self.onsets.to_csv(self.path("o.csv"))
        again = bl.Onsets.from_csv(self.path("o.csv"))
        for column in self.onsets:
            np.testing.assert_array_equal(again[column], self.onsets[column])

    def test_files_of_other_programs(self):
        with open(self.path("t.csv"), "w") as file:
            file.write("Nr;Zeit (ms)\n1;400,0\n2;1000,0\n3;1510,0\n4;1943,5\n")
        onsets = bl.Onsets.from_csv(self.path("t.csv"))
        np.testing.assert_allclose(onsets.t, [0.4, 1.0, 1.51, 1.9435], rtol=1e-12)
        self.assertRegex(onsets.summary["taken_for"][0], "times in ms")
        onsets = bl.Onsets.from_csv(self.path("t.csv"), columns="t=2", unit="s", taken_as="times")
        self.assertEqual(onsets.t[1], 1000.0)
        with open(self.path("asked.csv"), "w") as file:
            file.write("Nr;Zeit\n1;400,0\n2;1000,0\n3;1510,0\n4;1943,5\n")
        for read in (bl.Onsets.from_csv, bl.restitution):
            with self.assertRaisesRegex(ValueError, r"no title has a unit.*; say Onsets\.from_csv\(path, "
                                        r"taken_as='times', unit='ms', columns='t=Zeit'\) \(times in ms by column 'Zeit'\)"):
                read(self.path("asked.csv"))
        asked = bl.Onsets.from_csv(self.path("asked.csv"), taken_as="times", unit="ms", columns="t=Zeit")
        np.testing.assert_array_equal(asked.t, bl.Onsets.from_csv(self.path("t.csv")).t)
        with open(self.path("v.csv"), "w") as file:
            file.write("a;b\n1,2;0,85\n1,0;0,86\n")
        np.testing.assert_allclose(bl.Samples.from_csv(self.path("v.csv"), columns="v=a,eps=b").eps, [0.85, 0.86])

    def test_heights_are_those_of_a_table(self):
        with open(self.path("h.csv"), "w") as file:
            file.write("drop,h (cm)\n1,100\n1,81\n1,66\n1,53\n2,98.5\n2,80\n2,64\n")
        expected = bl.restitution(self.path("h.csv"), sigma_height=0.01)
        found = bl.restitution(heights=[[100, 81, 66, 53], np.array([98.5, 80, 64])], unit="cm", sigma_height=0.01)
        for column in ("drop", "v_mps", "eps", "sigma_eps"):
            np.testing.assert_array_equal(found[column], expected[column])
        np.testing.assert_array_equal(bl.restitution(heights=np.array([1, 0.81])).eps, [0.9])
        for heights, unit, message in [([1, 0], "m", "a height of 0"), ([1], "m", "one height"), ([1, 0.8], "s", "unit='s'"),
                                       ([], "m", "no line"), ([1, float("nan")], "m", "nan")]:
            with self.subTest(heights), self.assertRaisesRegex(ValueError, message):
                bl.restitution(heights=heights, unit=unit)
        with self.assertRaisesRegex(ValueError, "onsets or heights"):
            bl.restitution()

    def test_the_sound_shown_is_that_of_the_channel_with_the_ball(self):
        sound = small_sound(bl, small_impacts(bl, drops=1))
        onsets = bl.detect(np.stack([np.zeros_like(sound.samples), sound.samples], axis=1), sound.rate)
        self.assertGreater(max(json.loads(onsets._wave_json())["envelope"]["hi"]), 0.1)

    def test_the_message_says_what_was_found(self):
        self.assertRegex(self.onsets.message, "180 impacts in 6 drops")

    def test_a_temporary_analysis_goes_with_its_result(self):
        analysis = bl.analyze(os.path.join(SAMPLES, "clean.flac"))
        folder = analysis.folder
        self.assertIn(analysis.fit.answer.splitlines()[0], repr(analysis))
        self.assertIsNotNone(analysis.fit.shown_samples())
        self.assertTrue(os.path.exists(analysis.report))
        with self.assertRaisesRegex(TypeError, "name a folder"):
            copy.deepcopy(analysis)
        del analysis
        self.assertFalse(os.path.exists(folder))

    def test_a_temporary_loop_goes_with_its_result(self):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", bl.BouncelabWarning)
            loop = bl.loop(drops=2, impacts=15, asperities=5000, rate=22050, max_mode=10000)
        folder = loop.folder
        self.assertEqual(len(loop.onsets), 30)
        self.assertEqual(len(loop.truth), 30)
        self.assertTrue(os.path.exists(loop.report))
        del loop
        self.assertFalse(os.path.exists(folder))


@unittest.skipIf(matplotlib is None, "Matplotlib is not installed")
class Pictures(Case):
    @classmethod
    def setUpClass(cls):
        cls.fit = fitted()

    def test_they_are_drawn_where_one_wants_them(self):
        from matplotlib import pyplot

        figure, axes = pyplot.subplots(1, 3)
        self.addCleanup(pyplot.close, "all")
        sound = small_sound(bl, small_impacts(bl, drops=1))
        self.assertIs(bl.plot.restitution(self.fit, ax=axes[0]), axes[0])
        self.assertIs(bl.plot.density(self.fit, ax=axes[1]), axes[1])
        self.assertIs(bl.plot.sound(sound.samples, sound.rate, sound.truth, ax=axes[2]), axes[2])
        self.assertEqual(len(pyplot.get_fignums()), 1)  # none but ours
        figure.savefig(self.path("p.png"))
        self.assertIsNot(bl.plot.restitution(self.fit).figure, figure)
        curve = axes[0].get_lines()[-1]
        np.testing.assert_allclose(curve.get_ydata(), self.fit.eps(curve.get_xdata()).value)
        with self.assertRaisesRegex(ValueError, "window 99: the fit has"):
            bl.plot.density(self.fit, window=99)
        self.assertEqual(axes[1].get_ylabel(), "probability density p(ε)")
        self.assertEqual([text.get_text() for text in axes[1].get_legend().get_texts()][1], "two exponentials, fitted")
        self.assertRegex(axes[1].get_title(), "^impact speeds from .* to .* m/s$")

    def test_what_cannot_be_drawn_says_why(self):
        few = bl.fit(bl.Samples(v=[1.0, 0.9], eps=[0.9, 0.9]))
        with self.assertRaisesRegex(ValueError, "no window of speed"):
            bl.plot.density(few)
        for samples in ("drop.wav", np.zeros(0), None):
            with self.assertRaisesRegex(ValueError, "samples and their rate"):
                bl.plot.sound(samples, 48000)
        sound = small_sound(bl, small_impacts(bl, drops=1))
        self.assertEqual(bl.plot.sound(sound).get_xlabel(), "time (s)")

    def test_notebooks_show_the_answer_and_a_picture(self):
        from matplotlib import pyplot

        html = self.fit._repr_html_()
        self.assertIn("data:image/png;base64,", html)
        self.assertIn("ε", html)
        self.assertEqual(pyplot.get_fignums(), [])
        table = bl.Onsets(t=np.arange(12.0), recording=["<b>&"] * 12)._repr_html_()
        self.assertIn("&lt;b&gt;&amp;", table)
        self.assertIn("12 rows", table)
        self.assertIn("<img", small_sound(bl, small_impacts(bl, drops=1))._repr_html_())


if __name__ == "__main__":
    unittest.main()
