# SPDX-License-Identifier: GPL-3.0-or-later
"""Every function gives the numbers of the command of its name, bit for bit."""
import json
import os
import unittest
import wave

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


class Simulate(Case):
    def same(self, **keywords):
        out = self.path("impacts.csv")
        summary = printed("simulate", out=out, force=True, **keywords)
        impacts = quiet(bl.simulate, **keywords)
        self.assert_same_columns(impacts.to_dict(), out)
        self.assertEqual(impacts.summary, summary)
        again = self.path("again.csv")
        impacts.to_csv(again, force=True)
        self.assertEqual(read(again), read(out))

    def test_defaults_but_for_the_size(self):
        self.same(drops=3, impacts=10, asperities=5000)

    def test_states_of_the_ball(self):
        self.same(drops=2, impacts=8, asperities=5000, state=True, seed=7)

    def test_another_ball_with_drag_on_a_tilted_plate(self):
        self.same(drops=2, impacts=8, asperities=5000, ball="table-tennis", plate="concrete", drag=True, tilt=0.01,
                  spin=(1.5, -2.0, 0.25), plate_size=(0.5, 0.5))

    def test_laws_contacts_and_radii(self):
        self.same(drops=2, impacts=8, asperities=2000, law="viscoelastic:0.0467", contact="coulomb", mu=0.15,
                  radius_law="lognormal:1e-3,0.1", height=0.05)
        self.same(drops=1, impacts=5, asperities=2000, law="constant:0.9", contact="frictionless", height=(0.1, 0.2),
                  first_drop=12, max_time=1.5)

    def test_a_single_fall_of_a_smooth_ball(self):
        self.same(drops=1, impacts=1, asperities=1, min_speed=0.1)


class Synthesize(Case):
    def setUp(self):
        super().setUp()
        program("simulate", drops=2, impacts=10, asperities=5000, state=True, plate_size=(0.2, 0.2),
                out=self.path("i.csv"))
        self.impacts = bl.simulate(drops=2, impacts=10, asperities=5000, state=True, plate_size=(0.2, 0.2))

    def same(self, full_scale_bits, **keywords):
        program("synthesize", self.path("i.csv"), out=self.path("s.wav"), force=True, **keywords)
        sound = bl.synthesize(self.impacts, name=self.path("s.wav"), **keywords)
        self.assert_same_columns(sound.truth.to_dict(), self.path("s.truth.csv"))
        with open(self.path("s.wav"), "rb") as file:
            data = file.read()
        begin = data.index(b"data") + 8
        data = data[begin:begin + int.from_bytes(data[begin - 4:begin], "little")]
        if full_scale_bits == 32:
            expected = np.frombuffer(data, "<f4")
        elif full_scale_bits == 16:
            expected = (np.frombuffer(data, "<i2") / 2.0**15).astype(np.float32)
        else:
            octets = np.frombuffer(data, np.uint8).reshape(-1, 3).astype(np.int32)
            expected = octets[:, 0] | octets[:, 1] << 8 | octets[:, 2] << 16
            expected = ((expected - ((expected & 0x800000) << 1)) / 2.0**23).astype(np.float32)
        self.assertEqual(sound.samples.dtype, np.float32)
        np.testing.assert_array_equal(sound.samples.ravel(), expected)
        sound.write(self.path("again.wav"), force=True)
        with open(self.path("again.wav"), "rb") as again, open(self.path("s.wav"), "rb") as file:
            self.assertEqual(again.read(), file.read())
        return sound

    def test_24_bits(self):
        sound = self.same(24, **LOUD)
        self.assertEqual((sound.samples.ndim, sound.rate), (1, 22050))

    def test_16_bits(self):
        self.same(16, bits=16, **LOUD)

    def test_floats_with_every_disturbance(self):
        self.same(32, bits="float", hum=0.5, clicks=2.0, knocks=1.0, double_hits=0.3, drift=0.1, noise_corner=100.0,
                  robot=True, pause=2.5, timbre_wander=0.1, phase_wander=0.2, snr_db=20.0, seed=3, **LOUD)

    def test_several_channels(self):
        sound = self.same(24, channel=["0.05,0.02", "-0.05,0.02,0,0.5"], **LOUD)
        self.assertEqual(sound.samples.shape[1], 2)
        with wave.open(self.path("s.wav")) as file:
            self.assertEqual((file.getnchannels(), file.getnframes()), (2, len(sound.samples)))

    def test_ball_and_plate_go_on_from_the_simulation(self):
        program("simulate", drops=1, impacts=8, asperities=2000, ball="glass:16mm", plate="steel", out=self.path("i.csv"),
                force=True)
        self.impacts = bl.simulate(drops=1, impacts=8, asperities=2000, ball="glass:16mm", plate="steel")
        self.same(24, **LOUD)

    def test_other_sounds(self):
        program("synthesize", self.path("i.csv"), out=self.path("s.wav"), clicks=3, **LOUD)
        sound = bl.synthesize(self.impacts, clicks=3, **LOUD)
        self.assertGreater(len(sound.others["t_s"]), 0)
        self.assert_same_columns(sound.others, self.path("s.others.csv"))


class Detect(Case):
    def setUp(self):
        super().setUp()
        self.sound = small_sound(bl, bits="float")
        self.wav = self.path("s.wav")
        self.sound.write(self.wav)

    def command(self, *recordings, **keywords):
        self.out = self.path("o.csv")
        return printed("detect", *recordings, out=self.out, force=True, **keywords)

    def same(self, onsets, summary):
        self.assertGreater(len(onsets), 100)
        self.assert_same_columns(onsets.to_dict(), self.out)
        self.assertEqual(onsets.summary, summary)
        onsets.to_csv(self.path("again.csv"))
        self.assertEqual(read(self.path("again.csv")), read(self.out))

    def test_a_file(self):
        self.same(bl.detect(self.wav), self.command(self.wav))

    def test_an_array_of_one_channel(self):
        summary = self.command(self.wav)
        onsets = bl.detect(self.sound.samples, self.sound.rate, name=self.wav)
        for recording in (summary["recordings"][0], onsets.summary["recordings"][0]):
            recording.pop("format")  # samples have none
        self.same(onsets, summary)

    def test_an_array_of_two_channels(self):
        stereo = small_sound(bl, channel=["0.05,0.02", "-0.05,0.02,0,0.5"], bits="float")
        stereo.write(self.path("stereo.wav"))
        summary = self.command(self.path("stereo.wav"))
        onsets = bl.detect(stereo.samples, stereo.rate, name=self.path("stereo.wav"))
        for recording in (summary["recordings"][0], onsets.summary["recordings"][0]):
            recording.pop("format")
        self.same(onsets, summary)

    def test_the_second_of_two_channels(self):
        stereo = small_sound(bl, channel=["0.05,0.02", "-0.05,0.02,0,0.5"], bits="float")
        stereo.write(self.path("stereo.wav"))
        self.command(self.path("stereo.wav"), channel=1)
        onsets = bl.detect(stereo, name="ignored", channel=1)
        self.assertEqual(onsets.summary["recordings"][0]["channel"], 1)
        command = bl.Onsets.from_csv(self.out)
        for other in (command, bl.detect(stereo.samples[:, 1], stereo.rate)):
            np.testing.assert_array_equal(onsets.t, other.t)
            np.testing.assert_array_equal(onsets.sigma, other.sigma)

    def test_a_rate_that_is_no_integer(self):
        np.save(self.path("s.npy"), self.sound.samples)
        summary = self.command(self.path("s.npy"), rate=22050.5)
        self.same(bl.detect(self.path("s.npy"), 22050.5), summary)
        onsets = bl.detect(self.sound.samples, 22050.5, name=self.path("s.npy"))
        self.assert_same_columns(onsets.to_dict(), self.out)

    def test_several_files(self):
        names = [os.path.join(SAMPLES, "clean.flac"), os.path.join(SAMPLES, "hard.flac"), self.wav]
        self.same(bl.detect(names), self.command(*names))

    def test_a_file_given_twice(self):
        self.same(bl.detect([self.wav, self.wav]), self.command(self.wav, self.wav))

    def test_options(self):
        self.same(bl.detect(self.wav, min_impacts=5, channel=0), self.command(self.wav, min_impacts=5, channel=0))

    def test_nothing_is_found_in_silence(self):
        onsets = bl.detect(np.zeros(50000, np.float32), 44100)
        self.assertEqual((len(onsets), onsets.t.shape, onsets.t.dtype), (0, (0,), np.float64))
        self.assertEqual(onsets.message, "recording: nothing rises above the noise")


class Restitution(Case):
    def setUp(self):
        super().setUp()
        self.onsets = bl.detect(small_sound(bl))
        self.onsets.to_csv(self.path("o.csv"))

    def same(self, **keywords):
        summary = printed("restitution", self.path("o.csv"), out=self.path("r.csv"), force=True, **keywords)
        samples = bl.restitution(self.onsets, **keywords)
        self.assert_same_columns(samples.to_dict(), self.path("r.csv"))
        self.assertEqual(samples.summary, summary)
        samples.to_csv(self.path("again.csv"), force=True)
        self.assertEqual(read(self.path("again.csv")), read(self.path("r.csv")))
        self.assert_same_columns(bl.restitution(self.path("o.csv"), **keywords).to_dict(), self.path("r.csv"))

    def test_defaults(self):
        self.same()

    def test_a_ball_and_a_simulation(self):
        self.same(ball="steel:6mm", plate="glass")
        self.same(air=0)

    def test_a_drop_height_and_another_gravity(self):
        self.same(drop_height=0.095, gravity=9.7803)

    def test_travel_of_the_sound(self):
        small_impacts(bl, state=True).to_csv(self.path("i.csv"))
        self.same(positions=self.path("i.csv"), sensor_position=(0.05, -0.02), wave_speed=3000)

    def test_times_alone(self):
        times = [0, 1, 1.9, 2.71, 3.439]
        with open(self.path("o.csv"), "w", encoding="ascii") as file:  # few digits in a file would be rounded times
            file.write("t_s\n" + "".join(f"{t:.17g}\n" for t in times))
        self.onsets = bl.Onsets(t=times)
        self.same()


class FitsOfSamples(Case):
    @classmethod
    def setUpClass(cls):
        cls.samples = bl.restitution(bl.detect(small_sound(bl)))

    def setUp(self):
        super().setUp()
        self.csv = self.path("r.csv")
        self.samples.to_csv(self.csv)

    def same(self, **keywords):
        # 1: the constants cannot be told apart, of so few impacts; the curve can
        program("fit", self.csv, "--quiet", out=self.path("fit.json"), force=True, ok=(0, 1), **keywords)
        fit = quiet(bl.fit, self.samples, **keywords)
        self.assertEqual(fit._text, read(self.path("fit.json")))
        self.assertEqual(fit.results, bl.Fit.from_json(self.path("fit.json")).results)
        return fit

    def test_defaults(self):
        self.same()

    def test_two_nodes(self):
        self.assertEqual(list(self.same(nodes=[0.8, 1.1]).nodes), [0.8, 1.1])

    def test_orders(self):
        self.assertEqual(list(self.same(orders=[2, 4]).parameters), ["A2", "A4"])

    def test_methods_and_kinds(self):
        for method in ("asymmetric-laplace", "least-squares", "least-absolute", "memory"):
            self.same(method=method, goodness_replicates=0)
        for kind in ("viscoelastic", "constant"):
            self.same(law_kind=kind, goodness_replicates=0)

    def test_a_bootstrap(self):
        self.same(bootstrap=8, goodness_replicates=9, seed=5)

    def test_a_named_ball_windows_and_a_hand_off_speed(self):
        self.same(ball="steel:6mm", plate="glass", windows=[0.8, 1.0, 1.2], window_width=0.2, hand_off_speed=1.0,
                  goodness_replicates=0)

    def test_speeds_and_coefficients_alone(self):
        with open(self.csv, "w", encoding="ascii") as file:
            file.write("v_mps,eps\n")
            file.writelines(f"{float(v)!r},{float(e)!r}\n" for v, e in zip(self.samples.v, self.samples.eps))
        self.samples = bl.Samples(v=self.samples.v, eps=self.samples.eps)
        self.same(goodness_replicates=9)

    def test_roughness(self):
        for keywords in (dict(goodness_replicates=9), dict(goodness_replicates=0, ball="steel:6mm", plate="glass")):
            summary = printed("roughness", self.csv, **keywords)
            self.assertEqual(quiet(bl.roughness, self.samples, **keywords).results, summary)


class Calibrate(Case):
    def test_independent_samples(self):
        keywords = dict(samples=300, seeds=3, timing=8.7e-4)
        self.assertEqual(bl.calibrate(**keywords).results, printed("calibrate", **keywords))
        keywords = dict(samples=300, seeds=2, seed=4)
        self.assertEqual(bl.calibrate(**keywords).results, printed("calibrate", **keywords))

    def test_memory(self):
        keywords = dict(memory=True, experiments=1, drops=(5, 5), impacts=14)
        summary = printed("calibrate", out=self.path("e.csv"), **keywords)
        calibration = bl.calibrate(**keywords)
        self.assertEqual(calibration.results, summary)
        self.assert_same_columns(calibration.experiments, self.path("e.csv"))


class Loop(Case):
    def test_quick(self):
        keywords = dict(drops=2, impacts=15, asperities=5000, **LOUD)
        for folder in ("program", "function"):
            os.mkdir(self.path(folder))
        program("loop", "--quiet", out="run", cwd=self.path("program"), ok=(0, 1), **keywords)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(self.path("function"))
        loop = quiet(bl.loop, out="run", **keywords)
        files = sorted(name for name in os.listdir(self.path("program/run")) if not name.endswith(".meta.json"))
        self.assertIn("fit.json", files)
        for name in files:
            with open(self.path("program/run/" + name), "rb") as a, open(loop.path(name), "rb") as b:
                first, second = a.read(), b.read()
            self.assertGreater(len(second), 0, name)
            if name == "summary.json":
                first, second = without_seconds(first), without_seconds(second)
            if name == "report.html":  # tells how long the stages took
                continue
            self.assertEqual(first, second, name)
        self.assertEqual(without_seconds(json.dumps(loop.summary)), without_seconds(read(loop.path("summary.json"))))
        self.assertEqual(len(loop.impacts), 30)
        self.assertEqual(loop.fit._text, read(self.path("program/run/fit.json")))


def without_seconds(text):
    found = json.loads(text)
    return {name: value for name, value in found.items() if "second" not in name}


if __name__ == "__main__":
    unittest.main()
