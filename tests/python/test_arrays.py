# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays of any kind in, arrays that own their numbers out."""
import gc
import subprocess
import sys
import unittest

import bouncelab as bl
import numpy as np
from support import Case, memory, small_impacts, small_sound


class SoundIn(Case):
    @classmethod
    def setUpClass(cls):
        cls.sound = small_sound(bl, small_impacts(bl, drops=2), bits=16)
        cls.expected = bl.detect(cls.sound)

    def same(self, samples, rate=22050):
        onsets = bl.detect(samples, rate)
        np.testing.assert_array_equal(onsets.t, self.expected.t)
        np.testing.assert_array_equal(onsets.sigma, self.expected.sigma)

    def test_types_of_numbers(self):
        x = self.sound.samples
        self.same(x)
        self.same(x.astype(np.float64))
        self.same(x.astype(">f4"))
        self.same(x.astype(">f8"))
        self.same(x.tolist())
        self.same((x * 2.0**15).astype(np.int16))  # the sound has 16 bits: each sample is an integer over 2^15
        self.same((x * 2.0**15).astype(">i2"))
        self.same((x.astype(np.float64) * 2.0**31).astype(np.int32))

    def test_layouts(self):
        x = self.sound.samples
        spaced = np.zeros(2 * len(x), np.float32)
        spaced[::2] = x
        self.same(spaced[::2])
        self.same(np.ascontiguousarray(x[::-1])[::-1])
        self.same(x.reshape(-1, 1))
        frozen = x.copy()
        frozen.setflags(write=False)
        self.same(frozen)
        unaligned = np.frombuffer(b"x" + x.tobytes(), np.uint8)[1:].view(np.float32)
        self.same(unaligned)
        self.same(memoryview(x))
        two = np.stack([x, x], axis=1)
        self.same(np.asfortranarray(two)[:, 0])
        np.testing.assert_array_equal(bl.detect(np.asfortranarray(two), 22050).t, bl.detect(two, 22050).t)
        self.same(np.ma.masked_array(x))

    def test_what_is_no_sound(self):
        x = self.sound.samples
        spoiled = x.copy()
        for samples, message in [
                (np.array(["a", "b"]), "samples of <U1: give float32"),
                (np.array([None, 1.0]), "samples of object"),
                (x.astype(np.complex64), "samples of complex64"),
                (np.zeros(10, np.uint8), "samples of uint8"),
                (np.zeros(10, np.int64), "samples of int64"),
                (np.zeros(10, bool), "samples of bool"),
                (np.zeros((3, 3, 3), np.float32), "samples of 3 dimensions"),
                (np.float32(1.0), "samples of 0 dimensions"),
                (np.zeros((10, 0), np.float32), "0 channels"),
                (np.zeros((2, 2000), np.float32), "2000 channels"),
        ]:
            with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                bl.detect(samples, 22050)
        for value in (np.nan, np.inf, -np.inf, 5e19):
            spoiled[777] = value
            with self.assertRaisesRegex(ValueError, "sample 777 is not a finite number"):
                bl.detect(spoiled, 22050)

        two = np.zeros((1000, 2), np.float32)
        two[77, 1] = np.nan
        with self.assertRaisesRegex(ValueError, "sample 77 of channel 1 is not a finite number"):
            bl.detect(two, 22050)

    def test_sound_beyond_full_scale_is_the_same_beside_another_channel(self):
        """What a decoder gives may pass 1; it is not clipped on its way."""
        loud = 4 * small_sound(bl).samples
        self.assertGreater(np.abs(loud).max(), 1.0)
        alone = bl.detect(loud, 22050)
        beside = bl.detect(np.stack([loud, 0 * loud], axis=1), 22050, channel=0)
        self.assertGreater(len(alone), 0)
        for name in ("t_s", "sigma_t_s", "amplitude"):
            np.testing.assert_array_equal(alone[name], beside[name])

    def test_empty_sound(self):
        for samples in (np.zeros(0, np.float32), np.zeros((0, 2), np.float32), np.zeros(0, np.int16)):
            with self.assertRaisesRegex(ValueError, "holds no samples"):
                bl.detect(samples, 22050)
        self.assertEqual(len(bl.detect(np.zeros(1, np.float32), 22050)), 0)

    def test_float32_of_one_channel_is_not_copied(self):
        # 200 MB of zeros, and the peak of a process of its own; detection holds windows of a few seconds. A zero page
        # that is only read takes no memory of its own, so that the array is written first
        grown = int(subprocess.run([sys.executable, "-c", """
import bouncelab as bl, numpy as np, resource
bl.detect(np.zeros(100000, np.float32), 44100)
x = np.full(50_000_000, 0.0, np.float32)
x[:] = 1e-9
peak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
before = peak()
bl.detect(x, 4_000_000, channel=0)
print(peak() - before)
"""], capture_output=True, text=True, check=True).stdout) * 1024
        self.assertLess(grown, 150e6)  # of 200e6 for a copy


class TablesIn(Case):
    t = [0.0, 1.0, 1.9, 2.71, 3.439]

    def test_layouts_and_types(self):
        expected = bl.restitution(bl.Onsets(t=self.t)).eps
        array = np.array(self.t)
        spaced = np.zeros(10)
        spaced[::2] = array
        frozen = array.copy()
        frozen.setflags(write=False)
        for t in (array, spaced[::2], frozen, array.astype(">f8"), tuple(self.t)):
            np.testing.assert_array_equal(bl.restitution(bl.Onsets(t=t)).eps, expected)
            np.testing.assert_array_equal(bl.restitution({"t_s": t}).eps, expected)
            np.testing.assert_array_equal(bl.restitution(t).eps, expected)
        drops = bl.restitution([array, array + 7.0])
        np.testing.assert_array_equal(drops["drop"], [0, 0, 0, 1, 1, 1])
        np.testing.assert_allclose(drops.eps, np.tile(expected, 2), rtol=1e-12)  # of times 7 s later
        whole = bl.restitution(bl.Onsets(t=np.array([0, 10, 18, 25])))
        np.testing.assert_array_equal(whole.eps, bl.restitution(bl.Onsets(t=[0.0, 10.0, 18.0, 25.0])).eps)
        numbered = bl.Onsets(t=self.t, drop=np.zeros(5), impact=np.arange(5, dtype=np.uint16))
        np.testing.assert_array_equal(bl.restitution(numbered).eps, expected)

    def test_what_is_no_table(self):
        for columns, message in [
                (dict(t=[1, 2, np.nan, 3]), "onsets: row 3, column t_s: a number is missing"),
                (dict(t=[1, 2, np.inf, 3]), "row 3"),
                (dict(t=["a", "b"]), "onsets, column t_s: an array of <U1, not of numbers"),
                (dict(t=[[1, 2], [3, 4]]), "an array of 2 dimensions"),
                (dict(t=[1, 2, 3], drop=[0, 0]), "onsets: 3 rows of t_s, 2 of drop"),
                (dict(t=self.t, drop=[0, 0, 0, 0, 0.5], impact=range(5)), "0.5 is not an integer"),
                (dict(t=[1j, 2, 3]), "an array of complex128, not of numbers"),
                (dict(t=[]), "no three successive impacts"),
        ]:
            with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                bl.restitution(bl.Onsets(**columns))

    def test_samples_that_are_none_are_left_out_and_counted(self):
        v, eps = [1.0, np.nan, 1.0, -1.0, 1.0, 1.0], [0.9, 0.9, np.inf, 0.9, 0.91, 0.89]
        fit = bl.fit(bl.Samples(v=v, eps=eps), goodness_replicates=0)
        self.assertEqual(fit.results["n_used"], 3)
        self.assertEqual(sum(fit.results["n_left_out"].values()), 3)

    def test_masked_entries_are_missing(self):
        v, eps = np.full(9, 1.0), np.where(np.arange(9) < 3, 0.5, 0.9 + 0.001 * np.arange(9))
        expected = bl.fit({"v_mps": v, "eps": np.where(eps == 0.5, np.nan, eps)}, goodness_replicates=0)
        masked = np.ma.masked_array(eps, eps == 0.5)
        for samples in (bl.Samples(v=v, eps=masked), {"v_mps": v, "eps": masked}):
            self.assertEqual(bl.fit(samples, goodness_replicates=0).results, expected.results)
        self.assertEqual(expected.results["n_used"], 6)
        with self.assertRaisesRegex(ValueError, "row 3, column t_s: a number is missing"):
            bl.restitution({"t_s": np.ma.masked_array(self.t, [0, 0, 1, 0, 0])})
        with self.assertRaisesRegex(ValueError, "column drop, row 2: nan is not an integer"):
            bl.restitution(bl.Onsets(t=self.t, drop=np.ma.masked_array([0] * 5, [0, 1, 0, 0, 0])))
        names = bl.Onsets(t=self.t, recording=np.ma.masked_array(["a"] * 5, [0, 1, 0, 0, 0]))
        self.assertEqual(list(names.recording), ["a", "", "a", "a", "a"])

    def test_texts_of_another_alphabet(self):
        onsets = bl.Onsets(t=self.t, recording=["Kugel \u00e4\u03b5 \u2026"] * 5, drop=[0] * 5, impact=range(5))
        self.assertEqual(set(bl.restitution(onsets).recording), {"Kugel \u00e4\u03b5 \u2026"})


class ArraysOut(Case):
    def test_they_outlive_what_they_came_from(self):
        sound = small_sound(bl, small_impacts(bl, drops=2))
        onsets = bl.detect(sound)
        samples = bl.restitution(onsets)
        held = [onsets.t, onsets.sigma, samples.v, samples.eps, sound.samples, sound.truth.t, onsets.drop]
        copies = [array.copy() for array in held]
        for array in held:
            self.assertTrue(array.flags.writeable and array.flags.c_contiguous)
            self.assertEqual(type(array.base if not isinstance(array.base, np.ndarray) else array.base.base).__name__,
                             "PyCapsule")  # which owns the numbers
        del sound, onsets, samples
        gc.collect()
        spoil = [np.full(len(array), 7.0) for array in held for _ in range(20)]
        for array, copy in zip(held, copies):
            np.testing.assert_array_equal(array, copy)
        del spoil

    def test_results_are_independent_of_each_other(self):
        impacts = small_impacts(bl, drops=1)
        first = impacts.v.copy()
        impacts.v[:] = 0
        np.testing.assert_array_equal(small_impacts(bl, drops=1).v, first)

    def test_200_calls_do_not_leak(self):
        impacts = small_impacts(bl, drops=1, impacts=8)
        sound = small_sound(bl, impacts, rate=8000, max_mode=3900)  # 0.1 MB of samples
        law = "series:A2=0.0467,A4=0.1339,A5=-0.2876"

        def call():
            onsets = bl.detect(small_sound(bl, impacts, rate=8000, max_mode=3900))
            bl.restitution(onsets if len(onsets) > 2 else sound.truth).to_dict()
            bl._core.restitution_of_law(law, onsets.t + 1)
            for bad in (lambda: bl.detect(sound.samples.astype(str), 1), lambda: bl.simulate(drops=0)):
                with self.assertRaises(ValueError):
                    bad()

        for _ in range(20):  # caches and the allocator's own
            call()
        gc.collect()
        before = memory()
        for _ in range(200):
            call()
        gc.collect()
        # samples that 200 calls keep are 4 bytes each; what the allocator keeps does not grow with the calls
        self.assertLess(memory() - before, 200 * sound.samples.nbytes / 4)


class Pandas(Case):
    def test_series_and_empty_cells(self):
        try:
            import pandas as pd
        except ImportError:
            self.skipTest("pandas is not installed")
        times, heights = [0.0, 1.0, 1.9, 2.71], [1.0, 0.81, 0.66]
        series = pd.Series(times, index=[7, 3, 5, 1])
        np.testing.assert_array_equal(bl.restitution(series).eps, bl.restitution(times).eps)
        np.testing.assert_array_equal(bl.restitution(heights=pd.Series(heights, index=[2, 9, 4])).eps,
                                      bl.restitution(heights=heights).eps)
        samples = bl.restitution(times).to_pandas()
        samples["flags"] = samples["corrected"] = np.nan  # as read_csv has empty cells
        np.testing.assert_array_equal(bl.Samples.of(samples).eps, bl.restitution(times).eps)
        self.assertEqual(bl.fit(samples, goodness_replicates=0).results["n_used"], 2)

    def test_what_is_no_time(self):
        with self.assertRaisesRegex(ValueError, "numbers of seconds"):
            bl.restitution(np.array(["2026-11-30T10:00", "2026-11-30T10:01"], "datetime64[s]"))
        with self.assertRaisesRegex(ValueError, "times are in seconds"):
            bl.restitution([0.0, 1.0, 1.9], unit="ms")
        with self.assertRaisesRegex(TypeError, r"restitution\(onsets\)"):
            bl.fit(bl.Onsets(t=np.array([0.0, 1.0, 1.9])))
        with self.assertRaisesRegex(TypeError, "groups is a table with columns recording and plate"):
            bl.fit(bl.Samples(v=np.ones(9), eps=np.full(9, 0.9)), groups={"recording": ["a"]})


class Air(Case):
    def test_that_was_not_simulated_is_not_corrected(self):
        for drag in (False, True):
            sound = small_sound(bl, small_impacts(bl, drops=1, drag=drag))
            for onsets in (bl.detect(sound), sound.truth):
                found = bl.restitution(onsets, ball="steel:6mm", plate="glass")
                expected = bl.restitution(onsets, ball="steel:6mm", plate="glass", air=None if drag else 0)
                np.testing.assert_array_equal(found.to_dict()["air_kgpm3"], expected.to_dict()["air_kgpm3"])
                self.assertEqual(bool(np.nan_to_num(found.to_dict()["air_kgpm3"]).any()), drag)

if __name__ == "__main__":
    unittest.main()
