# SPDX-License-Identifier: GPL-3.0-or-later
"""Section of the page: how far each stage is from what one core can do at most (roofline)."""
import math
from dataclasses import dataclass

from measured import number, over, seconds, table, times, with_unit

FLOATS = "multiplications and additions, float"
DOUBLES = "multiplications and additions, double"
GIGA = {"T": 1e12, "G": 1e9, "M": 1e6, "": 1.0}
TRANSFORM = 4096     # samples, of the transforms of the detector
CONVOLUTION = 65536  # samples, of the transforms by which a drop could be convolved


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
    other_s: float = 0.0   # what is measured and cannot be avoided


def stages(measured):
    get = measured.get
    per_sample = lambda what: over(get("synthesize", "96000 Hz", what), 96000)
    transforms = 2 * 2.5 * CONVOLUTION * math.log2(CONVOLUTION) / (CONVOLUTION / 2)
    smooth = get("simulate", "uniform:5e-04,0.0015, N = 1000000", "impact of the smooth ball")
    latency = get("machine", "one core", "memory, latency")
    file_rate = get("machine", "one core", "file in memory, read")
    drops_s = get("detect", "drops, 44100 Hz", "sound")
    detect_s = get("detect", "drops, 44100 Hz", "bouncelab")
    return [
        Stage("noise generation", "sample", per_sample("noise alone"), 8, 16,
              "Philox: 10 rounds of 8 integer operations make 8 samples; 6 for the ziggurat. Written once as a double"),
        Stage("synthesis, one point a drop, with noise", "sample", per_sample("one point a drop"), 11, transforms + 6 + 16,
              f"the least known: convolution of a train of impulses with one response by overlapping transforms of {CONVOLUTION:,} (2 × 2.5 n log₂ n for n/2 samples), "
              "a complex product, noise. Written once as a double, and as 24 bits", fft_flop=transforms, fft_n=CONVOLUTION),
        Stage("reading PCM of 16 bits", "sample", over(get("kernels", "AudioReader::read, 2e6 of 16 bits", "bouncelab"), 2e6 // 2**14 * 2**14), 2, 1,
              "2 bytes of a file that is in memory, at the rate of reading one; the floats stay in the cache; one multiplication", other_s=over(2, file_rate) or 0),
        Stage("innovations, their energy, candidates (noise in memory)", "sample", get("detect", "noise in memory, 44100 Hz", "bouncelab, a sample"), 4, 98,
              "linear prediction of order 48: 96; the square and the sum: 2. Read once as a float"),
        Stage(f"Fourier transform of {TRANSFORM:,}", "sample", over(get("kernels", f"RealFft::forward, {TRANSFORM}", "bouncelab"), TRANSFORM), 8,
              2.5 * math.log2(TRANSFORM), "2.5 n log₂ n, as FFTW's authors count; read and written once as floats", fft_flop=2.5 * math.log2(TRANSFORM)),
        Stage("detection, the whole command at 44.1 kHz", "sample", over(detect_s, drops_s * 44100 if drops_s else None), 6, 99,
              "reading and innovations as above; the start of the program and the timing of eight impacts a second are on top and not counted"),
        Stage("contact search (uniform radii, N = 10⁶)", "impact", get("simulate", "uniform:5e-04,0.0015, N = 1000000", "impact"), 192, 400,
              "the smooth ball's impact as measured, then three lines of 64 bytes, each known only when the one before is there: node, list, asperity, at the latency of memory. "
              "Operations: eight asperities twice at 20, and 80 for the turning of the ball", doubles=True, other_s=(smooth or 0) + 3 * (latency or 0)),
        Stage("likelihood of the fit", "sample", get("fit", "density of a sample", "closed form, with four derivatives"), 56, 150,
              "two Mills ratios of 33, two exponentials of 15, sums and derivatives 54. Seven doubles read: ε, its error and inverse, log v, three of the law", doubles=True),
    ]


def limit_s(stage, limits):
    """The larger of what memory and arithmetic need."""
    arithmetic = (stage.flop - stage.fft_flop) / limits["double" if stage.doubles else "float"] + stage.fft_flop / limits[stage.fft_n]
    return max(stage.n_bytes / limits["memory"], arithmetic, stage.other_s)


def rows_of(measured, limits):
    for stage in stages(measured):
        if stage.cost_s is None:
            continue
        limit = limit_s(stage, limits)
        by = ("latency" if stage.unit == "impact" else "file") if limit == stage.other_s else "memory" if limit == stage.n_bytes / limits["memory"] else "transforms" if stage.fft_flop else "arithmetic"
        yield (stage.name, stage.unit, seconds(stage.cost_s), number(stage.n_bytes), number(stage.flop), seconds(limit), by,
               number(stage.cost_s / limit) + " ×", with_unit(stage.flop / stage.cost_s, "FLOP/s", GIGA))


def kernels(measured):
    rows = []
    for case in measured.cases("kernels"):
        ours = measured.get("kernels", case, "bouncelab")
        baseline = next(what for what in measured.names("kernels", case) if what != "bouncelab")
        rows.append((case, baseline, seconds(ours), times(measured.get("kernels", case, baseline), ours)))
    return table(("", "baseline", "a call", "faster than the baseline"), rows)


def roofline(measured):
    get = lambda what: measured.get("machine", "one core", what)
    limits = {"memory": get("memory, copied"), "float": get(FLOATS), "double": get(DOUBLES), **{n: get(f"FFTW, float, n = {n}") for n in (TRANSFORM, CONVOLUTION)}}
    machine = [(what, with_unit(value, "s", {"µ": 1e-6, "n": 1e-9}) if "latency" in what else with_unit(value, "FLOP/s" if "copied" not in what and "read" not in what else "B/s", GIGA))
               for what in measured.names("machine", "one core") if (value := get(what))]
    counted = "\n".join(f"- **{stage.name}**: {stage.counted}." for stage in stages(measured) if stage.cost_s is not None)
    return """## What the machine could do (roofline)

One core of this machine, measured in the same run: memory by `memcpy` of 256 MiB (bytes read and written both count) and by following random addresses in 256 MiB; arithmetic by ten independent chains of fused multiplications and additions in registers, the widest that the processor has (two operations each);
FFTW planned by estimate; a file of 64 MiB that is in memory, read.

""" + table(("limit", "one core"), machine) + """
Each stage against those limits. *Bytes* and *FLOP* are what the stage cannot do without, counted by hand as stated below, for one sample of sound or one impact. *Limit* is the time that they need at the machine's rates, the largest of memory and arithmetic (transforms at FFTW's rate, the rest at the peak); *how far* is the measured time over it.
1 would be a stage that nothing can make faster but another method (below 1: faster than FFTW). FLOP counts what is needed, not what is done: FLOP/s is the useful rate.

""" + table(("stage", "of a", "measured", "bytes", "FLOP", "limit", "set by", "how far", "useful rate"), list(rows_of(measured, limits))) + f"""
How they are counted:

{counted}

The loops of which those stages are made, against plain ones compiled alike, FFTW and libsndfile (least of 30 rounds in turn, one thread):

""" + kernels(measured)
