# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of sound: read through ffmpeg, written as 24-bit WAV; lengths, pieces, and the two parts of every set."""
import functools
import hashlib
import os
import subprocess
import wave

import numpy as np

EXTENSIONS = ("wav", "ogg", "oga", "flac", "mp3", "aiff", "aif", "opus")  # what the program reads


def part_of(name):
    """'build' or 'held out', by a hash of the file's name without its extension: half of any set each, the same for ever."""
    base = os.path.basename(name)
    stem, _, extension = base.rpartition(".")
    stem = stem if extension.lower() in EXTENSIONS else base
    return ("build", "held out")[hashlib.sha256(stem.encode("utf-8", "surrogateescape")).digest()[0] % 2]


def output_of(command):
    return subprocess.run(command, capture_output=True, check=True).stdout


@functools.lru_cache(maxsize=None)
def header_of(path):
    """Rate in Hz, channels, length in s; None where ffprobe sees no sound."""
    try:
        text = output_of(["ffprobe", "-v", "error", "-select_streams", "a:0", "-show_entries", "stream=sample_rate,channels:format=duration",
                          "-of", "default=noprint_wrappers=1", path]).decode()
        fields = dict(line.split("=", 1) for line in text.split() if "=" in line)
        return int(fields["sample_rate"]), int(fields["channels"]), float(fields["duration"])
    except (subprocess.CalledProcessError, LookupError, ValueError):
        return None


def read(path):
    """(rate_hz, samples[n, channel]), full scale 1."""
    rate_hz, n_channels, _ = header_of(path)
    raw = output_of(["ffmpeg", "-v", "quiet", "-i", path, "-map", "0:a:0", "-f", "f32le", "-c:a", "pcm_f32le", "-"])
    return rate_hz, np.frombuffer(raw, "<f4").reshape(-1, n_channels).astype(float)


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


def below(folder):
    """Every file of sound in a folder and its subfolders, by name; a link is no second file."""
    paths = [os.path.join(place, name) for place, _, names in os.walk(folder) for name in names]
    return sorted(path for path in paths if path.lower().rsplit(".", 1)[-1] in EXTENSIONS and not os.path.islink(path))
