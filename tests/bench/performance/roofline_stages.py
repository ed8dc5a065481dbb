# SPDX-License-Identifier: GPL-3.0-or-later
"""What each stage costs, as measured, and the bytes and operations that it cannot do without, as counted by hand."""
import math
from dataclasses import dataclass

from measured import over

TRANSFORM = 4096     # samples, of the transforms of the detector
IN_TURN = 8          # drops that are simulated together, kDropsInTurn of sim
RINGING = 1024      # samples, of the transform by which many modes ring


@dataclass(frozen=True)
class Stage:
    """What a stage costs and what it cannot do without, of one sample or impact."""
    name: str
    unit: str
    cost_s: float | None
    n_bytes: float
    flop: float
    counted: str
    fft_flop: float = 0.0  # of flop: in Fourier transforms of fft_n, at FFTW's speed
    fft_n: int = TRANSFORM
    doubles: bool = False
    other: str = ""        # what else sets a limit, and the time that it takes
    other_s: float = 0.0


def transforms_of(n, count):
    """FLOP of so many real Fourier transforms."""
    return count * 2.5 * n * math.log2(n)


def timing_s(measured):
    """Of an impact at 44.1 kHz."""
    what = ("sound", "bouncelab", "impacts")
    sound_s, cost_s, n_impacts = (measured.get("detect", "drops, 44100 Hz", name) for name in what)
    noise_s, start_s = measured.get("detect", "noise in memory, 44100 Hz", "bouncelab, a sample"), measured.get("start-up", "bouncelab --version", "processor, least")
    known = None not in (sound_s, cost_s, n_impacts, noise_s, start_s)
    return (cost_s - start_s - noise_s * sound_s * 44100) / n_impacts if known else None


def contact_search(measured, name, ball, n_mib):
    """@param n_mib  of the latency that is measured, nearest to the index"""
    smooth_s, latency_s = measured.get("simulate", ball, "impact of the smooth ball"), measured.get("machine", "one core", f"latency in {n_mib} MiB")
    known = None not in (smooth_s, latency_s)
    return Stage(f"impact in simulation ({name})", "impact", measured.get("simulate", ball, "impact") if known else None, 192, 400,
                 f"the smooth ball's impact as measured, then three lines of 64 bytes, each known only when the one before is there (node, list, asperity), at the latency in {n_mib} MiB, for which {IN_TURN} drops wait together. "
                 "Operations: eight asperities twice at 20, and 80 for the turning of the ball", doubles=True, other="latency", other_s=smooth_s + 3 * latency_s / IN_TURN if known else 0.0)


def detection(measured, rate_hz, bits):
    """Whole commands: what the steps of one core need, one after the other, but for the timing of impacts."""
    get = measured.get
    sound_s, cost_s = (get("detect", f"drops, {rate_hz} Hz", what) for what in ("sound", "bouncelab"))
    n_bytes, flop = bits // 8, 98
    steps_s = (over(n_bytes, get("machine", "one core", "file in memory, read")), over(n_bytes, get("machine", "one core", "SHA-256 of bytes in the cache")),
               over(flop, get("machine", "one core", "multiplications and additions, float")))
    return Stage(f"detection, the whole command at {rate_hz / 1000:g} kHz", "sample", over(cost_s, sound_s * rate_hz if sound_s else None), n_bytes, flop,
                 "read once, its SHA-256 (each block of 64 bytes waits for the one before), innovations as above, one after the other on one core; "
                 "the start of the program and the timing of eight impacts a second are on top and not counted", other="checksum, file, arithmetic",
                 other_s=sum(steps_s) if None not in steps_s else 0.0)


def stages(measured):
    get = measured.get
    per_sample = lambda what: over(get("synthesize", "96000 Hz", what), 96000)
    transforms = transforms_of(RINGING, 1) / (RINGING / 2)
    file_rate = get("machine", "one core", "file in memory, read")
    return [
        Stage("noise generation", "sample", per_sample("noise alone"), 8, 38,
              "Philox: 10 rounds of 6 integer operations make 4 samples; 46 for the logarithm, root, sine and cosine of two. Written once as a double"),
        Stage("synthesis, one point a drop, with noise", "sample", per_sample("one point a drop"), 11, transforms + 38,
              f"the least known: the ringing of all modes by one transform of {RINGING:,} for n/2 samples (2.5 n log₂ n), and noise. Written once as a double, and as 24 bits", fft_flop=transforms, fft_n=RINGING),
        Stage("reading PCM of 16 bits", "sample", over(get("kernels", "AudioReader::read, 2e6 of 16 bits", "bouncelab"), 2e6 // 2**14 * 2**14), 2, 1,
              "2 bytes of a file that is in memory, at the rate of reading one; the floats stay in the cache; one multiplication", other="file", other_s=over(2, file_rate) or 0),
        Stage("innovations, their energy, candidates (noise in memory)", "sample", get("detect", "noise in memory, 44100 Hz", "bouncelab, a sample"), 4, 98,
              "linear prediction of order 48: 96; the square and the sum: 2. Read once as a float"),
        Stage(f"Fourier transform of {TRANSFORM:,}", "sample", over(get("kernels", f"RealFft::forward, {TRANSFORM}", "bouncelab"), TRANSFORM), 8,
              transforms_of(TRANSFORM, 1) / TRANSFORM, "2.5 n log₂ n, as FFTW's authors count; read and written once as floats", fft_flop=transforms_of(TRANSFORM, 1) / TRANSFORM),
        detection(measured, 44100, 16),
        detection(measured, 96000, 24),
        Stage("timing of an impact", "impact", timing_s(measured), 16384, transforms_of(2048, 2) + 6 * 1025,
              "the whole command less its start and less noise of the same length, over the impacts. One matched filter: a transform of 2,048 samples forth and back and a complex product; "
              "the method needs tens of them, for the template, the alignment and the sub-bands", fft_flop=transforms_of(2048, 2)),
        contact_search(measured, "equal radii, N = 10⁶, an index of 70 MB", "constant:0.001, N = 1000000", 64),
        contact_search(measured, "uniform radii, N = 10⁶, an index of 10 MB", "uniform:5e-04,0.0015, N = 1000000", 8),
        Stage("likelihood of the fit", "sample", get("fit", "likelihood of a sample, timing noise 1.7 of the scatter", "with its gradient"), 56, 150,
              "with its gradient, timing noise 1.7 of the scatter: two Mills ratios of 33, two exponentials of 15, sums and derivatives 54. Seven doubles read: ε, its error and inverse, log v, three of the law", doubles=True),
    ]
