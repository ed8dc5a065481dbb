# SPDX-License-Identifier: GPL-3.0-or-later
"""Long work beside Python: Ctrl-C, progress, threads."""
import signal
import subprocess
import sys
import threading
import time
import unittest

import bouncelab as bl
import numpy as np
from support import Case, small_impacts, small_sound

LONG = {
    "simulate": "bl.simulate(drops=100000)",
    "fit": "bl.fit(samples, goodness_replicates=50000)",
    "detect": "[bl.detect(noise, 44100) for _ in range(100)]",  # each takes a second
}
# the state of what follows, and the work; SIGINT comes while it goes on
SCRIPT = """
import sys, time, warnings
import numpy as np
import bouncelab as bl
warnings.simplefilter("ignore")
impacts = bl.simulate(drops=6, impacts=30, asperities=20000)
samples = bl.Samples(v=impacts.v, eps=impacts.eps)
noise = np.random.default_rng(1).standard_normal(44100 * 20).astype(np.float32) * np.float32(0.1)
noise = np.tile(noise, 60) if "noise" in {work!r} else noise
print("ready", flush=True)
try:
    begin = time.perf_counter()
    {work}
    print("no interrupt")
except KeyboardInterrupt:
    print("interrupted after", time.perf_counter() - begin)
print(len(bl.simulate(drops=1, impacts=5, asperities=1000)), len(bl.detect(noise[:44100], 44100)))
"""


class CtrlC(Case):
    def interrupted(self, work):
        script = SCRIPT.format(work=work)
        with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True) as process:
            self.assertEqual(process.stdout.readline(), "ready\n")
            time.sleep(0.3)
            process.send_signal(signal.SIGINT)
            try:
                # the work itself would take a minute and more
                rest, _ = process.communicate(timeout=30)
            except subprocess.TimeoutExpired:
                process.kill()
                raise
        first, second = rest.splitlines()
        self.assertTrue(first.startswith("interrupted"), first)
        print(work, first, "s; asked for after .3 s")
        self.assertEqual(second, "5 0")  # and what follows works
        self.assertEqual(process.returncode, 0)

    def test_it_ends_every_kind_of_work(self):
        for name, work in LONG.items():
            with self.subTest(name):
                self.interrupted(work)

    def test_what_the_handler_of_another_signal_raises_ends_the_work(self):
        class Enough(Exception):
            pass

        def enough(*_):
            raise Enough

        for number in (signal.SIGALRM, signal.SIGTERM):
            before = signal.signal(number, enough)
            try:
                timer = threading.Timer(0.3, signal.raise_signal, [number])
                timer.start()
                begin = time.perf_counter()
                with self.assertRaises(Enough):
                    bl.simulate(drops=100000)  # a minute
                self.assertLess(time.perf_counter() - begin, 20)
                timer.join()
            finally:
                signal.signal(number, before)
            self.assertEqual(len(small_impacts(bl, drops=1)), 30)

    def test_a_handler_that_raises_nothing_runs_meanwhile(self):
        seen = []
        before = signal.signal(signal.SIGALRM, lambda *_: seen.append(time.perf_counter()))
        try:
            signal.setitimer(signal.ITIMER_REAL, 0.1)
            bl.simulate(drops=2000, impacts=60, asperities=100000, threads=1)
            end = time.perf_counter()
        finally:
            signal.signal(signal.SIGALRM, before)
        self.assertLess(seen[0], end - 0.05)

    def test_it_does_not_come_twice(self):
        """A handler of the user's own sees it once; what follows is not stopped."""
        seen = []
        before = signal.signal(signal.SIGINT, lambda *_: seen.append(1))
        try:
            timer = threading.Timer(0.2, signal.raise_signal, [signal.SIGINT])
            timer.start()
            self.assertEqual(len(bl.simulate(drops=2000, impacts=60, asperities=100000)), 120000)
            timer.join()
            self.assertEqual(seen, [1])
            self.assertEqual(len(small_impacts(bl, drops=1)), 30)
        finally:
            signal.signal(signal.SIGINT, before)


class Progress(Case):
    def test_a_function_is_called(self):
        impacts = small_impacts(bl)
        works = [(lambda p: bl.simulate(drops=30, impacts=30, asperities=20000, progress=p), "simulate", "drops"),
                 (lambda p: small_sound(bl, impacts, progress=p), "synthesize", "segments"),
                 (lambda p: bl.detect(small_sound(bl, impacts), progress=p), "detect", "s of sound"),
                 (lambda p: bl.fit(bl.Samples(v=impacts.v, eps=impacts.eps), goodness_replicates=10, progress=p), "fit", "fits")]
        for work, label, unit in works:
            calls = []
            work(lambda *call: calls.append(call))
            with self.subTest(label):
                mine = [call for call in calls if call[0] == label]
                self.assertTrue(mine)
                self.assertTrue(all(call[3] == unit for call in mine), mine)
                done = [call[1] for call in mine]
                self.assertTrue(all(0 <= d <= call[2] for d, call in zip(done, mine)))
                self.assertEqual(done[-1], mine[-1][2])  # the end is always told

    def test_what_it_raises_ends_the_work_and_arrives_unchanged(self):
        class Mine(Exception):
            pass

        mine = Mine("enough", 3)

        def stop(*_):
            raise mine

        for work in (lambda: bl.simulate(drops=100000, progress=stop),):
            with self.assertRaises(Mine) as raised:
                work()
            self.assertIs(raised.exception, mine)
        self.assertEqual(len(small_impacts(bl, drops=1)), 30)

    def test_bars_and_what_is_neither(self):
        expected = small_impacts(bl, drops=2)
        np.testing.assert_array_equal(small_impacts(bl, drops=2, progress=False).v, expected.v)
        with self.assertRaisesRegex(TypeError, "progress: None, True or a function"):
            small_impacts(bl, progress="bar")
        import contextlib
        import io

        with contextlib.redirect_stderr(io.StringIO()) as shown:
            np.testing.assert_array_equal(small_impacts(bl, drops=2, progress=True).v, expected.v)
        try:
            import tqdm  # noqa: F401
        except ImportError:
            self.assertEqual(shown.getvalue(), "")
        else:
            self.assertIn("simulate", shown.getvalue())


class Threads(Case):
    def test_two_threads_at_once_give_the_numbers_of_one(self):
        sound = small_sound(bl)

        def work(k, found):
            impacts = small_impacts(bl, seed=1 + k % 2)
            found[k] = (impacts.v, bl.detect(sound).t, bl.fit(bl.Samples(v=impacts.v, eps=impacts.eps),
                                                             goodness_replicates=9)._text)

        alone = {}
        for k in range(2):
            work(k, alone)
        together = {}
        threads = [threading.Thread(target=work, args=(k, together)) for k in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for k in range(4):
            for a, b in zip(together[k], alone[k % 2]):
                np.testing.assert_array_equal(a, b)

    def test_other_threads_of_python_run_meanwhile(self):
        ended, turns = threading.Event(), []

        def count():
            while not ended.is_set():
                turns.append(time.perf_counter())
                time.sleep(0.001)

        thread = threading.Thread(target=count)
        thread.start()
        begin = time.perf_counter()
        bl.simulate(drops=200, impacts=60, asperities=100000, threads=1)
        end = time.perf_counter()
        ended.set()
        thread.join()
        meanwhile = sum(begin < turn < end for turn in turns)
        # the lock held would leave the other thread no turn between begin and end, but for one on either side
        self.assertGreater(meanwhile, 5)

    def test_work_in_another_thread_leaves_ctrl_c_alone(self):
        handler = signal.getsignal(signal.SIGINT)
        thread = threading.Thread(target=lambda: small_impacts(bl))
        thread.start()
        thread.join()
        self.assertIs(signal.getsignal(signal.SIGINT), handler)
        with self.assertRaises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)


if __name__ == "__main__":
    unittest.main()
