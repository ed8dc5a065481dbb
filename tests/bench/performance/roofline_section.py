# SPDX-License-Identifier: GPL-3.0-or-later
"""Section of the page: how far each stage is from what one core can do at most (roofline)."""
from measured import number, seconds, table, times, with_unit
from roofline_stages import RINGING, TRANSFORM, stages

FLOATS = "multiplications and additions, float"
DOUBLES = "multiplications and additions, double"
GIGA = {"T": 1e12, "G": 1e9, "M": 1e6, "": 1.0}


def limit_of(stage, limits):
    """(seconds, what sets them): the largest of what memory, arithmetic and anything else need."""
    arithmetic_s = (stage.flop - stage.fft_flop) / limits["double" if stage.doubles else "float"] + stage.fft_flop / limits[stage.fft_n]
    return max((stage.n_bytes / limits["memory"], "memory"), (arithmetic_s, "transforms" if stage.fft_flop else "arithmetic"), (stage.other_s, stage.other))


def rows_of(measured, limits):
    for stage in stages(measured):
        if stage.cost_s is None:
            continue
        limit_s, set_by = limit_of(stage, limits)
        yield (stage.name, stage.unit, seconds(stage.cost_s), number(stage.n_bytes), number(stage.flop), seconds(limit_s), set_by,
               number(stage.cost_s / limit_s) + " ×", with_unit(stage.flop / stage.cost_s, "FLOP/s", GIGA))


def kernels(measured):
    rows = []
    for case in measured.cases("kernels"):
        ours = measured.get("kernels", case, "bouncelab")
        baseline = next(what for what in measured.names("kernels", case) if what != "bouncelab")
        rows.append((case, baseline, seconds(ours), times(measured.get("kernels", case, baseline), ours)))
    return table(("", "baseline", "a call", "faster than the baseline"), rows)


def roofline(measured):
    get = lambda what: measured.get("machine", "one core", what)
    limits = {"memory": get("memory, copied"), "float": get(FLOATS), "double": get(DOUBLES), **{n: get(f"FFTW, float, n = {n}") for n in (TRANSFORM, RINGING)}}
    units = {"s": ("s", {"µ": 1e-6, "n": 1e-9}), "B/s": ("B/s", GIGA), "FLOP/s": ("FLOP/s", GIGA)}
    machine = [(what, with_unit(get(what), *units[measured.unit("machine", "one core", what)])) for what in measured.names("machine", "one core")]
    counted = "\n".join(f"- **{stage.name}**: {stage.counted}." for stage in stages(measured) if stage.cost_s is not None)
    return """## What the machine could do (roofline)

One core of this machine, measured in the same run: memory by `memcpy` of 256 MiB (bytes read and written both count) and by following random addresses in 8, 64 and 256 MiB (*latency*); arithmetic by ten independent chains of fused multiplications and additions in registers, the widest that the processor has (two operations each);
FFTW planned by estimate; the first byte written to each page of 4 KiB, which the system sets to zero then; a file of 64 MiB that is in memory, read; SHA-256 by Nettle, which takes the processor's instructions for it.

""" + table(("limit", "one core"), machine) + """
Each stage against those limits. *Bytes* and *FLOP* are what the stage cannot do without, counted by hand as stated below, for one sample of sound or one impact. *Limit* is the time that they need at the machine's rates, the largest of memory and arithmetic (transforms at FFTW's rate, the rest at the peak); *how far* is the measured time over it.
1 would be a stage that nothing can make faster but another method (below 1: faster than FFTW). FLOP counts what is needed, not what is done: FLOP/s is the useful rate.

""" + table(("stage", "of a", "measured", "bytes", "FLOP", "limit", "set by", "how far", "useful rate"), list(rows_of(measured, limits))) + f"""
How they are counted:

{counted}

The loops of which those stages are made, against plain ones compiled alike, FFTW and libsndfile (least of 30 rounds in turn, one thread):

""" + kernels(measured)
