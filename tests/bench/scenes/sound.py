# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of sound, written as 24-bit WAV, and their truth."""
import csv
import wave

import numpy as np


def write(path, rate_hz, samples):
    """24-bit WAV; what exceeds full scale is clipped."""
    samples = np.asarray(samples, float)
    samples = samples[:, None] if samples.ndim == 1 else samples
    whole = np.round(np.clip(samples, -1, 1 - 2.0**-23) * 2**23).astype("<i4")
    with wave.open(path, "wb") as file:
        file.setnchannels(samples.shape[1])
        file.setsampwidth(3)
        file.setframerate(rate_hz)
        file.writeframes(np.ascontiguousarray(whole).view(np.uint8).reshape(-1, 4)[:, :3].tobytes())


def write_truth(path, columns, rows):
    with open(path, "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(columns)
        table.writerows(rows)
