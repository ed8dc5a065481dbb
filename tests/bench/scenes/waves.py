# SPDX-License-Identifier: GPL-3.0-or-later
"""Sounds of struck bodies at exact times, rooms and noise; independent of the project's own synthesizer.

A body is a sum of damped modes exp(-t/tau) sin(2 pi f t) that a half-sine pulse of the duration of contact excites; both are known as Fourier
integrals, so that an onset lies at any time, not on a sample, and nothing is aliased."""
import dataclasses

import numpy as np

LEAD = 64  # samples of room before an onset: a linear-phase converter rings before it


@dataclasses.dataclass(frozen=True)
class Body:
    """Modes at f_hz with decay time tau_s and amplitude; a contact lasts contact_s at 1 m/s."""
    rate_hz: int
    f_hz: np.ndarray
    tau_s: np.ndarray
    amplitude: np.ndarray
    contact_s: float


def body(rng, rate_hz, low_hz, high_hz, n_modes, quality, contact_s):
    """Modes drawn evenly on a logarithmic scale, quality factors between the two given."""
    f_hz = np.exp(rng.uniform(np.log(low_hz), np.log(min(high_hz, 0.45 * rate_hz)), n_modes))
    q = np.exp(rng.uniform(*np.log(quality), n_modes))
    return Body(rate_hz, f_hz, q / (np.pi * f_hz), rng.standard_normal(n_modes), contact_s)


def hard_ball(rng, rate_hz):
    """Steel, glass, table tennis, golf on something hard."""
    low_hz = min(rng.uniform(400, 2500), 0.2 * rate_hz)
    return body(rng, rate_hz, low_hz, 20e3, rng.integers(12, 40), (15, rng.choice([40, 120, 400])), np.exp(rng.uniform(np.log(30e-6), np.log(300e-6))))


def soft_ball(rng, rate_hz):
    """Rubber, basketball, football: a wide pulse and a dull floor."""
    return body(rng, rate_hz, rng.uniform(60, 150), rng.uniform(900, 2500), rng.integers(6, 16), (2, 12), rng.uniform(1.5e-3, 6e-3))


def pulse_spectrum(omega, contact_s):
    """Fourier integral of a half sine of unit impulse."""
    p = np.pi / contact_s
    below = np.where(np.abs(omega - p) < 1e-6 * p, omega + 2e-6 * p, omega)
    return 0.5 * p * p * (1 + np.exp(-1j * below * contact_s)) / (p * p - below**2)


class Voice:
    """Impacts of one body: `wander` scatters the amplitudes of its modes from one impact to the next."""

    def __init__(self, struck, wander, longest_s=0.6):
        self.struck, self.wander = struck, wander
        lasts_s = min(longest_s, 7 * float(np.max(struck.tau_s)) + 0.01)
        self.n = 1 << int(np.ceil(np.log2(lasts_s * struck.rate_hz + 4 * LEAD)))
        self.omega = 2 * np.pi * np.fft.rfftfreq(self.n, 1 / struck.rate_hz)
        w, decay = 2 * np.pi * struck.f_hz[:, None], 1 / struck.tau_s[:, None]
        self.modes = (w / ((decay + 1j * self.omega) ** 2 + w * w)).astype(np.complex64)
        edge = np.clip((self.omega / (np.pi * struck.rate_hz) - 0.86) / 0.14, 0, 1)
        self.converter = np.cos(0.5 * np.pi * edge) ** 2

    def impact(self, speed_mps, fraction, rng):
        """Samples of one impact of unit loudness at LEAD + fraction."""
        scatter = np.exp(self.wander * rng.standard_normal(len(self.struck.f_hz)))
        spectrum = (self.struck.amplitude * scatter).astype(np.complex64) @ self.modes
        spectrum = spectrum * pulse_spectrum(self.omega, self.struck.contact_s * max(speed_mps, 1e-3)**-0.2) * self.converter
        return np.fft.irfft(spectrum * np.exp(-1j * self.omega * (LEAD + fraction) / self.struck.rate_hz), self.n)


def add(buffer, wave, at):
    """Adds a wave whose sample 0 lies at the integer sample `at`; what is outside is lost."""
    begin, end = max(0, at), min(len(buffer), at + len(wave))
    if begin < end:
        buffer[begin:end] += wave[begin - at:end - at]


def struck_at(voice, t_s, speed_mps, loudness, duration_s, rng):
    """(sound, peak of each impact)."""
    rate_hz = voice.struck.rate_hz
    out, peaks = np.zeros(int(duration_s * rate_hz)), []
    unit = np.max(np.abs(voice.impact(1.0, 0.0, np.random.default_rng(0))))
    for t, v, a in zip(t_s, speed_mps, loudness):
        whole = int(np.floor(t * rate_hz))
        wave = a / unit * voice.impact(v, t * rate_hz - whole, rng)
        peaks.append(np.max(np.abs(wave)))
        add(out, wave, whole - LEAD)
    return out, np.array(peaks)


def convolved(sound, response):
    n = 1 << int(np.ceil(np.log2(len(sound) + len(response))))
    return np.fft.irfft(np.fft.rfft(sound, n) * np.fft.rfft(response, n), n)[:len(sound)]


def room(rng, rate_hz, strength):
    """A few early echoes, then a diffuse decay; strength 0 is the open air, 1 a bad kitchen."""
    rt60_s = rng.uniform(0.15, 0.7)
    t = np.arange(int(rt60_s * rate_hz)) / rate_hz
    response = 0.03 * strength * rng.standard_normal(len(t)) * 10**(-3 * t / rt60_s) * np.clip(t / 4e-3, 0, 1)
    response *= np.sqrt(48e3 / rate_hz)
    response[0] = 1
    for _ in range(rng.integers(1, 4)):
        response[int(rng.uniform(1.5e-3, 16e-3) * rate_hz)] += strength * rng.uniform(0.1, 0.5) * rng.choice([-1, 1])
    return response


def noise(rng, n, rate_hz, slope, hum=0.0):
    """Unit rms: power falls as f^(-slope) from 30 Hz on; hum of 50 Hz and its harmonics."""
    f_hz = np.fft.rfftfreq(n, 1 / rate_hz)
    spectrum = (rng.standard_normal(len(f_hz)) + 1j * rng.standard_normal(len(f_hz))) * np.maximum(f_hz, 30)**(-0.5 * slope)
    out = np.fft.irfft(spectrum, n)
    out /= np.std(out)
    t = np.arange(n) / rate_hz
    for k in (1, 2, 3):
        out += hum / k * np.sin(2 * np.pi * 50 * k * t + rng.uniform(0, 6))
    return out
