# SPDX-License-Identifier: GPL-3.0-or-later
"""Section of the page: detection."""
from measured import bar, count, number, over, seconds, table, times

SCIPY = "SciPy's trigger + stack + correlation"
BARS = {"drops, 44100 Hz": 2500, "drops, 96000 Hz": 1500}


def contenders(measured):
    rows = []
    for case, least in BARS.items():
        sound = measured.get("detect", case, "sound")
        ours = measured.get("detect", case, "bouncelab")
        for name in ("bouncelab", "aubioonset", SCIPY):
            get = lambda what, case=case, name=name: measured.get("detect", case, f"{name}, {what}")
            cost = measured.get("detect", case, name)
            if cost is None:
                rows.append((name, case, *["not installed"] * 6))
                continue
            rows.append((name, case, seconds(cost), number(sound / cost) + " ×", times(cost, ours) if name != "bouncelab" else "1",
                         f"{number(get('recall'))} / {number(get('precision'))}", seconds(get("median error")),
                         bar(sound / cost, least=least, unit=" ×") if name == "bouncelab" else ""))
    return table(("", "sound", "processor", "times real time", "over bouncelab", "recall / precision", "median error", "bar"), rows)


def channels_and_threads(measured):
    get = lambda what: measured.get("detect", "channels and threads", what)
    rows = []
    for name in ("mono, one thread", "mono, two threads", "stereo, one thread", "stereo, two threads"):
        cpu, wall = get(f"{name}, processor"), get(f"{name}, wall")
        rows.append((name, seconds(cpu), times(cpu, get("mono, one thread, processor")), seconds(wall),
                     times(get(f"{name.split(',')[0]}, one thread, wall"), wall)))
    return table(("", "processor", "over mono, one thread", "wall, least", "faster than one thread"), rows)


def without_a_ball(measured):
    rows = []
    for case in measured.cases("detect", "without a ball: "):
        sound, ours, aubio = [measured.get("detect", case, what) for what in ("sound", "bouncelab", "aubioonset")]
        rows.append((case.removeprefix("without a ball: "), seconds(ours), number(sound / ours) + " ×", times(aubio, ours) if aubio else "",
                     bar(sound / ours, least=200, unit=" ×")))
    return table(("", "processor", "times real time", "aubioonset over bouncelab", "bar"), rows)


def detect(measured):
    sound = measured.get("detect", "drops, 44100 Hz", "sound")
    noise = [(rate, seconds(cost), number(over(1, cost * rate)) + " ×")
             for rate in (44100, 96000) if (cost := measured.get("detect", f"noise in memory, {rate} Hz", "bouncelab, a sample"))]
    return f"""## Detection

`bouncelab detect` as a whole command on one thread, from the start of the program to the table of onsets, on {number(sound / 60)} min of the paper's drops in noise (WAV of 16 bits at 44.1 kHz, of 24 bits at 96 kHz), full of impacts: 95 in each 12 s.
`aubioonset` is a general onset detector in C; *SciPy* is what one would write in an afternoon: a trigger, a stack and a cross-correlation (`tests/bench/trigger_stack.py`), of which Python's start and imports are not counted. The three took turns; least of {count(measured.get("detect", "drops, 44100 Hz", "bouncelab, runs"))} runs.
*Median error*: of the times, about the median of each drop. aubioonset is not made for such times.

""" + contenders(measured) + """
Several channels, and several threads:

""" + channels_and_threads(measured) + """
Recordings without a ball, which no detector should be slow on, WAV of 16 bits at 44.1 kHz. *Bursts* are like speech or music: coloured noise of 20 to 300 ms with sharp begins, several a second, over one another.

""" + without_a_ball(measured) + """
Noise in memory, what a sample costs before there is anything to be timed:

""" + table(("rate, Hz", "a sample", "times real time"), noise)
