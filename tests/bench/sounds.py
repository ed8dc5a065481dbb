# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings for the benchmarks: the paper's drops by `bouncelab synthesize`, and sounds without a ball. The same bytes in every run."""
import math
import wave
from pathlib import Path

import numpy as np
from scipy import signal

from bench_lines import cost_of

DROP_S = 11.8  # of the paper's drops of 95 impacts, pause included


def drops(program, folder, length_s, rate_hz, bits=16, channels=1):
    """The paper's ball, one drop after the other in noise at 30 dB. @return (sound, truth)"""
    sound = Path(folder) / f"drops_{length_s:g}s_{rate_hz}Hz_{channels}ch.wav"
    truth = sound.with_suffix(".truth.csv")
    if not sound.exists():
        impacts = Path(folder) / f"drops_{length_s:g}s.csv"
        if not impacts.exists():
            cost_of([program, "simulate", "--drops", max(1, round(length_s / DROP_S)), "--impacts", 95, "--asperities", 100000,
                     "--out", impacts, "--quiet"])
        command = [program, "synthesize", impacts, "--rate", rate_hz, "--bits", bits, "--max-mode", min(45e3, 0.45 * rate_hz), "--out",
                   sound, "--truth", truth, "--quiet"]
        if channels > 1:  # sensors on a circle around the middle
            angles = [2 * math.pi * k / channels for k in range(channels)]
            command += ["--channel"] + [f"{0.08 * math.cos(a):.4f},{0.08 * math.sin(a):.4f}" for a in angles]
        cost_of(command)
    return str(sound), str(truth)


def length_s(path):
    with wave.open(path) as file:
        return file.getnframes() / file.getframerate()


def bursts(generator, n, rate_hz, per_s):
    """Like speech or music: bursts of coloured noise of 20 to 300 ms with sharp begins, several a second, over one another."""
    out = 1e-3 * generator.standard_normal(n)
    for begin in generator.integers(0, n, int(per_s * n / rate_hz)):
        length = min(int(rate_hz * generator.uniform(0.02, 0.3)), n - begin)
        t_s = np.arange(length) / rate_hz
        envelope = np.minimum(t_s / generator.uniform(5e-4, 5e-3), 1) * np.exp(-t_s * generator.uniform(15, 80))
        radius, angle = generator.uniform(0.9, 0.995), 2 * math.pi * generator.uniform(200, 8000) / rate_hz
        sound = signal.lfilter([1 - radius], [1, -2 * radius * math.cos(angle), radius**2], generator.standard_normal(length))
        out[begin:begin + length] += 10 ** generator.uniform(-1.5, 0) * envelope * sound
    return out


def without_a_ball(kind, generator, n, rate_hz):
    t_s = np.arange(n) / rate_hz
    if kind == "silence":
        return np.zeros(n)
    if kind == "white noise":
        return 0.05 * generator.standard_normal(n)
    if kind == "tone of 440 Hz in faint noise":
        return 0.3 * np.sin(2 * math.pi * 440 * t_s) + 1e-4 * generator.standard_normal(n)
    if kind == "a click every 50 ms":
        clicks = np.zeros(n)
        clicks[::rate_hz // 20] = 0.06
        return signal.lfilter([1], [1, -1.8, 0.9], clicks) + 1e-3 * generator.standard_normal(n)
    return bursts(generator, n, rate_hz, {"5 bursts a second": 5, "20 bursts a second": 20}[kind])


KINDS = ("silence", "white noise", "tone of 440 Hz in faint noise", "a click every 50 ms", "5 bursts a second", "20 bursts a second")


def kind_of_sound(folder, kind, length_s, rate_hz):
    """WAV of 16 bits, made minute by minute."""
    path = Path(folder) / f"{kind.replace(' ', '_')}_{length_s:g}s.wav"
    if not path.exists():
        generator = np.random.default_rng(22)
        with wave.open(str(path), "wb") as file:
            file.setparams((1, 2, rate_hz, 0, "NONE", ""))
            for begin_s in range(0, int(length_s), 60):
                samples = without_a_ball(kind, generator, int(min(60, length_s - begin_s) * rate_hz), rate_hz)
                file.writeframes(np.round(32767 * np.clip(samples, -1, 1)).astype("<i2").tobytes())
    return str(path)
