# SPDX-License-Identifier: GPL-3.0-or-later
"""Every function gives the numbers of the command of its name, bit for bit: both call the same stages."""
import json
import os
import unittest

import bouncelab as bl
import numpy as np
from support import SAMPLES, Case, printed, program, read, small_impacts, small_sound

LOUD = dict(rate=22050, max_mode=10000)


def quiet(function, *arguments, **keywords):
    """The result, without its warnings, which other tests look at."""
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", bl.BouncelabWarning)
        return function(*arguments, **keywords)


class Stages(Case):
    def test_simulate(self):
        out = self.path("impacts.csv")
        for keywords in (dict(drops=2, impacts=8, asperities=5000, state=True, ball="table-tennis", plate="concrete",
                              drag=True, tilt=0.01, spin=(1.5, -2.0, 0.25), plate_size=(0.5, 0.5), seed=7),
                         dict(drops=2, impacts=8, asperities=2000, law="viscoelastic:0.0467", contact="coulomb",
                              mu=0.15, radius_law="lognormal:1e-3,0.1", height=(0.1, 0.2), first_drop=12, max_time=1.5)):
            summary = printed("simulate", out=out, force=True, **keywords)
            impacts = quiet(bl.simulate, **keywords)
            self.assert_same_columns(impacts.to_dict(), out)
            self.assertEqual(impacts.summary, summary)
            impacts.to_csv(self.path("again.csv"), force=True)
            self.assertEqual(read(self.path("again.csv")), read(out))

    def test_synthesize(self):
        """Disturbances, several channels, and the ball of the simulation; samples of 24 bits and floats."""
        of_ball = dict(drops=2, impacts=10, asperities=5000, state=True, plate_size=(0.2, 0.2), ball="glass:16mm")
        program("simulate", out=self.path("i.csv"), **of_ball)
        impacts = bl.simulate(**of_ball)
        for keywords in (dict(channel=["0.05,0.02", "-0.05,0.02,0,0.5"]),
                         dict(bits="float", hum=0.5, clicks=2.0, knocks=1.0, double_hits=0.3, drift=0.1, pause=2.5,
                              noise_corner=100.0, timbre_wander=0.1, phase_wander=0.2, snr_db=20.0, seed=3)):
            program("synthesize", self.path("i.csv"), out=self.path("s.wav"), force=True, **keywords, **LOUD)
            sound = bl.synthesize(impacts, name=self.path("s.wav"), **keywords, **LOUD)
            self.assert_same_columns(sound.truth.to_dict(), self.path("s.truth.csv"))
            with open(self.path("s.wav"), "rb") as file:
                whole = file.read()
            begin = whole.index(b"data") + 8
            data = whole[begin:begin + int.from_bytes(whole[begin - 4:begin], "little")]
            if "bits" in keywords:
                expected = np.frombuffer(data, "<f4")
                self.assert_same_columns(sound.others, self.path("s.others.csv"))
            else:
                octets = np.frombuffer(data, np.uint8).reshape(-1, 3).astype(np.int32)
                expected = octets[:, 0] | octets[:, 1] << 8 | octets[:, 2] << 16
                expected = ((expected - ((expected & 0x800000) << 1)) / 2.0**23).astype(np.float32)
                self.assertEqual(sound.samples.shape[1], 2)
            self.assertEqual((sound.samples.dtype, sound.rate), (np.float32, 22050))
            np.testing.assert_array_equal(sound.samples.ravel(), expected)
            sound.write(self.path("again.wav"), force=True)
            with open(self.path("again.wav"), "rb") as again:
                self.assertEqual(again.read(), whole)

    def test_detect(self):
        """Files, an array of two channels, the second of them alone, and a rate that is no integer."""
        out, wav, npy = self.path("o.csv"), self.path("s.wav"), self.path("s.npy")
        stereo = small_sound(bl, channel=["0.05,0.02", "-0.05,0.02,0,0.5"], bits="float")
        stereo.write(wav)
        np.save(npy, stereo.samples[:, 0])
        names = [os.path.join(SAMPLES, "hard.flac"), wav, wav]  # the same twice counts once
        for onsets, recordings, keywords in (
                (bl.detect(names), names, {}), (bl.detect(stereo.samples, stereo.rate, name=wav), [wav], {}),
                (bl.detect(wav, min_impacts=5, channel=1, drop_height=0.1), [wav],
                 dict(min_impacts=5, channel=1, drop_height=0.1)),
                (bl.detect(stereo.samples[:, 0], 22050.5, name=npy), [npy], dict(rate=22050.5))):
            summary = printed("detect", *recordings, out=out, force=True, **keywords)
            self.assertGreater(len(onsets), 100)
            self.assert_same_columns(onsets.to_dict(), out)
            for recording in summary["recordings"] + onsets.summary["recordings"]:
                recording.pop("format")  # samples have none
            self.assertEqual(onsets.summary["recordings"], summary["recordings"])
            onsets.to_csv(self.path("again.csv"), force=True)
            self.assertEqual(read(self.path("again.csv")), read(out))
        silent = bl.detect(np.zeros(50000, np.float32), 44100)
        self.assertEqual((len(silent), silent.t.shape, silent.t.dtype), (0, (0,), np.float64))
        self.assertIn("recording: no sound is louder than the noise", silent.message)

    def test_restitution(self):
        sound = small_sound(bl)  # as an array, of which nobody knows that there was no air
        onsets, csv, out = bl.detect(sound.samples, sound.rate), self.path("o.csv"), self.path("r.csv")
        onsets.to_csv(csv)
        for keywords in ({}, dict(ball="steel:6mm", plate="glass", drop_height=0.095, gravity=9.7803),
                         dict(wave_speed=3000, air=0)):
            summary = printed("restitution", csv, out=out, force=True, **keywords)
            samples = bl.restitution(onsets, **keywords)
            self.assert_same_columns(samples.to_dict(), out)
            self.assertEqual(samples.summary, summary)
            samples.to_csv(self.path("again.csv"), force=True)
            self.assertEqual(read(self.path("again.csv")), read(out))
            self.assert_same_columns(bl.restitution(csv, **keywords).to_dict(), out)

    def test_the_world_goes_with_the_tables(self):
        """Ball, plate, gravity and air of a simulation: from its impacts, from its sound, in a file and in memory."""
        os.chdir(self.folder)  # recordings are called as their files
        self.addCleanup(os.chdir, "/")
        for drag in ({}, {"drag": True}):
            of_ball = dict(drops=6, impacts=30, asperities=100000, ball="glass:16mm", plate="steel", gravity=9.7, **drag)
            program("simulate", out="i.csv", force=True, **of_ball)
            program("synthesize", "i.csv", out="s.wav", force=True, **LOUD)
            program("detect", "s.wav", out="o.csv", force=True)
            impacts = bl.simulate(**of_ball)
            sound = bl.synthesize(impacts, name="s.wav", **LOUD)
            impacts.to_csv("i2.csv", force=True)
            for file, tables in (("i.csv", (impacts, "i.csv", "i2.csv", impacts[:])),
                                 ("o.csv", (bl.detect("s.wav"), bl.detect(sound), "o.csv"))):
                program("restitution", file, out="r.csv", force=True)
                for table in tables:
                    self.assert_same_columns(bl.restitution(table).to_dict(), "r.csv")
                program("fit", "r.csv", "--quiet", out="f.json", force=True, ok=(0, 1), goodness_replicates=0)
                fit = quiet(bl.fit, bl.restitution(tables[0]), goodness_replicates=0)
                self.assertEqual(fit._text, read("f.json"))
            self.assertEqual(bl.restitution(impacts).summary["ball"]["name"], "glass:16mm")
            sound.write("s2.wav", force=True)
            self.assertEqual(bl.detect("s2.wav").world, impacts.world)
            keywords = dict(ball="steel:6mm", air=0.5, gravity=9.81)  # they win
            program("restitution", "o.csv", out="r.csv", force=True, **keywords)
            self.assert_same_columns(bl.restitution("o.csv", **keywords).to_dict(), "r.csv")
            program("analyze", "s.wav", out="a", force=True, quiet=True, ok=(0, 1), goodness_replicates=0)
            self.assert_same_columns(bl.restitution("a/onsets.csv").to_dict(), "a/samples.csv")

    def test_fits_of_samples(self):
        samples, csv, out = bl.restitution(bl.detect(small_sound(bl))), self.path("r.csv"), self.path("fit.json")
        samples.to_csv(csv)
        alone = bl.Samples(v=samples.v, eps=samples.eps)
        with open(self.path("alone.csv"), "w", encoding="ascii") as file:
            file.write("v_mps,eps\n")
            file.writelines(f"{float(v)!r},{float(e)!r}\n" for v, e in zip(samples.v, samples.eps))
        for keywords, table, file in ((dict(nodes=[0.8, 1.1], orders=[2, 4], goodness_replicates=9, seed=5), samples, csv),
                                      (dict(method="memory", ball="steel:6mm", plate="glass", windows=[0.8, 1.0, 1.2],
                                            window_width=0.2, hand_off_speed=1.0, goodness_replicates=0), samples, csv),
                                      (dict(law_kind="viscoelastic"), alone, self.path("alone.csv"))):
            # 1: the constants cannot be told apart, of so few impacts; the curve can
            program("fit", file, "--quiet", out=out, force=True, ok=(0, 1), **keywords)
            fit = quiet(bl.fit, table, **keywords)
            self.assertEqual(fit._text, read(out))
            self.assertEqual(fit.results, bl.Fit.from_json(out).results)
            if "nodes" in keywords:
                self.assertEqual((list(fit.nodes), list(fit.parameters)), ([0.8, 1.1], ["A2", "A4"]))
        plates = self.path("plates.csv")
        with open(plates, "w", encoding="utf-8") as file:
            file.write("recording,plate\n0.wav,glass\n1.wav,wood\n")
        two = bl.Samples({**samples, "recording": [f"{drop // 3}.wav" for drop in samples.drop]})
        two.to_csv(self.path("two.csv"))
        program("fit", self.path("two.csv"), "--quiet", groups=plates, out=out, force=True, ok=(0, 1), goodness_replicates=0)
        fit = quiet(bl.fit, two, groups=plates, goodness_replicates=0)
        self.assertEqual(fit._text, read(out))
        self.assertEqual(fit.results["recordings_are"], "plates")
        self.assertEqual([row["recording"] for row in fit.results["recordings"]], ["glass", "wood"])
        keywords = dict(goodness_replicates=9, ball="steel:6mm", plate="glass")
        self.assertEqual(quiet(bl.roughness, samples, **keywords).results, printed("roughness", csv, **keywords))
    def test_dem(self):
        impacts, file = small_impacts(bl), self.path("fit.json")
        fit = bl.fit(bl.Samples(v=impacts.v, eps=impacts.eps), goodness_replicates=0)
        with open(file, "w", encoding="utf-8") as out:
            out.write(fit._text)
        for keywords in ({}, dict(code="liggghts", youngs_modulus=1e8), dict(code="c++", model="fluctuating")):
            expected = program("dem", file, **keywords)
            self.assertGreater(len(expected), 100)
            self.assertEqual((bl.dem(fit, **keywords), bl.dem(file, **keywords)), (expected, expected))


class Folders(Case):
    def both(self, command, *words, **keywords):
        """What the function of the command gives. Of the program's files it has every one, byte for byte."""
        for folder in ("program", "function"):
            os.makedirs(self.path(folder), exist_ok=True)
        program(command, *words, "--quiet", out=command, cwd=self.path("program"), ok=(0, 1), **keywords)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(self.path("function"))
        found = quiet(getattr(bl, command), *([list(words)] if words else []), out=command, **keywords)
        self.assertEqual(sorted(os.listdir(command)), sorted(os.listdir(self.path(f"program/{command}"))))
        for name in os.listdir(command):
            if name.endswith(".meta.json"):  # has the command line
                continue
            with open(self.path(f"program/{command}/{name}"), "rb") as a, open(found.path(name), "rb") as b:
                first, second = a.read(), b.read()
            self.assertGreater(len(second), 0, name)
            if name == "summary.json":
                first, second = without_seconds(first), without_seconds(second)
            if name == "report.html" and command == "loop":  # tells how long the stages took
                continue
            self.assertEqual(first, second, name)
        return found

    def test_analyze(self):
        """Several sounds, with options of each stage, and heights by a table of elsewhere."""
        names = [os.path.join(SAMPLES, name) for name in ("clean.flac", "hard.flac")]
        found = self.both("analyze", *names, ball="steel:6mm", plate="glass", min_impacts=5, goodness_replicates=9, diagnostics=True)
        self.assertEqual((found.summary, found.fit._text), (json.loads(read(found.path("summary.json"))), read(found.path("fit.json"))))
        self.assertEqual((len(found.onsets), len(found.samples)), (found.summary["n_onsets"], found.summary["n_samples"]))
        with open(self.path("heights.csv"), "w", encoding="ascii") as file:
            file.write("1,.81,.66,.53,.43\n".replace(",", "\n"))
        found = self.both("analyze", self.path("heights.csv"), taken_as="heights", unit="m", force=True)
        self.assertEqual(len(found.samples), 4)

    def test_compare(self):
        """Files of samples, with plates, and the same tables in memory."""
        tables = [bl.Samples(v=i.v, eps=i.eps - 0.01 * k, drop=i.drop, impact=i.impact, recording=["ab"[k]] * len(i))
                  for k, i in enumerate(small_impacts(bl, drops=3, seed=1 + k) for k in range(2))]
        for k, table in enumerate(tables):
            table.to_csv(self.path(f"{k + 1}.csv"))
        with open(self.path("plates.csv"), "w", encoding="ascii") as file:
            file.write("recording,plate\na,glass\nb,wood\n")
        keywords = dict(groups=self.path("plates.csv"), title="Plates")
        found = self.both("compare", self.path("1.csv"), self.path("2.csv"), **keywords)
        self.assertEqual(found.results, json.loads(read(found.path("comparison.json"))))
        self.assertEqual([row["plate"] for row in found.recordings], ["glass", "wood"])
        self.assertIn("glass", found.answer)
        self.assertAlmostEqual(found.differences[0]["eps"]["value"], -0.01, delta=0.005)
        self.assertEqual(quiet(bl.compare, tables, **keywords).results, found.results)
        alike = [dict(table, recording=["drop"] * len(table)) for table in tables]
        self.assertEqual([row["recording"] for row in quiet(bl.compare, alike).recordings], ["drop", "drop (2)"])

    def test_loop(self):
        loop = self.both("loop", drops=2, impacts=15, asperities=5000, **LOUD)
        self.assertEqual(without_seconds(json.dumps(loop.summary)), without_seconds(read(loop.path("summary.json"))))
        self.assertEqual(len(loop.impacts), 30)
        self.assertEqual(loop.fit._text, read(self.path("program/loop/fit.json")))


def without_seconds(text):
    found = json.loads(text)
    return {name: value for name, value in found.items() if "second" not in name and "memory" not in name}


if __name__ == "__main__":
    unittest.main()
