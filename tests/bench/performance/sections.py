# SPDX-License-Identifier: GPL-3.0-or-later
"""Sections of the page: the closed loop, synthesis, simulation, fit, start."""
from measured import bar, count, number, over, seconds, size, table, times


def loop(measured):
    case = measured.cases("loop")[0]
    get = lambda what: measured.get("loop", case, what)
    wall, processor = get("whole command, wall"), get("whole command, processor")
    stages = list(dict.fromkeys(what.rsplit(", ", 1)[0] for what in measured.names("loop", case) if what.endswith(", processor")))
    rows = []
    for stage in stages:
        whole = stage == "whole command"
        cpu = get(f"{stage}, processor")
        rows.append((stage.replace("_", " "), seconds(get(f"{stage}, wall")) if get(f"{stage}, wall") else "", seconds(cpu),
                     f"{number(100 * cpu / processor)} %", seconds(over(cpu, get("impacts"))),
                     f"{bar(wall, most=20, unit=' s on the clock')}; {bar(processor, most=40, unit=' s of processors')}"
                     if whole and case == "paper" else ""))
    size_of_run = "the paper's experiment" if case == "paper" else f"a part of the paper's experiment ({case})"
    return f"""## The closed loop

`bouncelab loop --preset paper --no-memory`: {size_of_run}, {count(get('impacts'))} impacts simulated, their sound of {number(get('sound') / 3600)} h at 96 kHz synthesized and detected in memory, ε(v) fitted to the true
and to the detected times. One run on all cores (its ratio is that to real time); at most {size(get('peak memory'))} of memory. Stages are as the program itself measures them; synthesis and detection run side by side
and have one time on the clock, `sound`.

""" + (f"{number(get('sound') / wall)} times real time as a whole.\n\n") + table(
        ("stage", "wall", "processors", "share", "per impact", "bar"), rows + sound_row(get))


def sound_row(get):
    wall = get("sound, wall")
    return [("sound (synthesize and detect together)", seconds(wall), "", "", seconds(over(wall, get("impacts"))), "")] if wall else []


def synthesize(measured):
    rows = []
    for case in ("44100 Hz", "96000 Hz"):
        get = lambda what, case=case: measured.get("synthesize", case, what)
        direct = get("direct sum")
        for what in ("one point a drop", "a point for each impact", "a recording for each drop", "noise alone"):
            ratio = times(direct, get(what)) if what != "noise alone" else ""
            rows.append((what, case.replace(" Hz", ""), count(get("modes")), number(over(1, get(what))) + " ×", ratio))
        rows.append(("direct sum (the baseline)", case.replace(" Hz", ""), count(get("modes")), number(over(1, direct)) + " ×", "1"))
    memory = [(case, seconds(measured.get("synthesize", case, "sound")), size(measured.get("synthesize", case, "peak memory so far")))
              for case in measured.cases("synthesize") if case.endswith("to a file")]
    return """## Synthesis

Impact times to sound, one thread, in memory, ten of the paper's drops on a glass plate. The baseline is the direct sum: every impact adds every mode of the plate as a damped sine, until it has decayed by 10⁻¹¹; it makes no noise.
*One point a drop*: all impacts of a drop are at one place of the plate, *a point for each impact*: each at its own. *A recording for each drop* is what the loop does. Least of three runs. Nothing else is known to
synthesize such recordings.

""" + table(("", "rate, Hz", "modes", "times real time", "faster than the direct sum"), rows) + """
Memory does not grow with the length (most that the process held, through a file at 8 kHz):

""" + table(("", "sound", "peak memory"), memory)


def simulate(measured):
    rows, largest = [], {}
    for case in measured.cases("simulate"):
        law, n = case.rsplit(", N = ", 1)
        if int(n) in {10**k for k in range(3, 10)}:
            largest[law] = int(n)
    for case in measured.cases("simulate"):
        law, n = case.rsplit(", N = ", 1)
        if int(n) not in {10**k for k in range(3, 10)}:
            continue
        get = lambda what, case=case: measured.get("simulate", case, what)
        smooth, judged = over(get("impact"), get("impact of the smooth ball")), int(n) == 10**6
        rows.append((f"`{law}`", f"{int(n):,}", seconds(get("envelope")), number(over(get("bytes of the index"), int(n))), seconds(get("impact")),
                     number(smooth) + " ×", times(get("impact by brute force"), get("impact")),
                     f"{bar(smooth, most=4, unit=' ×')}; {bar(get('envelope'), most=1.5, unit=' s')}" if judged else ""))
    return """## Simulation

Cost of an impact of a ball with N asperities, one thread, 200 drops of 100 impacts (eight drops take turns, so that none waits for memory alone), for the laws of their radii (in units of the ball's). Two baselines: the same flights of the *smooth ball*, which has none and takes turns with the rough one,
and *brute force*, which looks at each asperity for each impact. The *envelope* is built once for a ball; *B/N* are the bytes of its index over N. Bars at N = 10⁶: 4 times the smooth ball, 1.5 s for the envelope.

""" + table(("radii", "N", "envelope", "B/N", "impact", "over the smooth ball", "faster than brute force", "bars: impact; envelope"), rows)


def fit(measured):
    text = """## Fit

ε(v) fitted to independent samples, one thread, with profile intervals. iminuit maximises the same likelihood, written with NumPy, and finds the intervals of ε at three speeds by MINOS; bouncelab those of ε and of the three constants too, by sample
or by drop. *Difference*: between the two estimates of ε, the largest of three speeds, in standard errors (bouncelab's density has a share of lost bounces and a free normal part besides).

"""
    rows = []
    for case in measured.cases("fit"):
        if "samples" not in case:
            continue
        get = lambda what, case=case: measured.get("fit", case, what)
        law, minuit = get("law with profile intervals"), get("iminuit, profile intervals")
        differences = [abs(over(get(f"eps({v}), iminuit") - get(f"eps({v}), bouncelab"), get(f"eps({v}), standard error")))
                       for v in ("0.25", "0.60", "1.20") if get(f"eps({v}), iminuit") and get(f"eps({v}), standard error")]
        rows.append((case, seconds(law), seconds(get("histograms")), seconds(minuit), seconds(get("iminuit, MIGRAD alone")), times(minuit, law),
                     number(max(differences), 2) if differences else ""))
    text += table(("", "bouncelab, law", "bouncelab, histograms", "iminuit", "iminuit, no intervals", "faster than iminuit", "difference"), rows)
    closed, brute = [measured.get("fit", "density of a sample", what) for what in ("closed form, with four derivatives", "convolution by quadrature")]
    return text + f"""
By brute force the density of a sample, two exponentials convolved with a normal, is a sum over 257 points: {seconds(brute)}. The closed form with its four derivatives takes {seconds(closed)}, {times(brute, closed)} less.
The fit *with memory*, the default for long drops, has no peer; what it costs stands under "How cost grows".
"""


def start_up(measured):
    rows = []
    base = measured.get("start-up", "true", "wall, median")
    bars = {"bouncelab --version": 5e-3, "bouncelab detect, 12 s of sound": 12e-3}
    for case in measured.cases("start-up"):
        wall = measured.get("start-up", case, "wall, median")
        least = measured.get("start-up", case, "processor, least")
        rows.append((f"`{case}`" if "," not in case else case, seconds(wall), times(wall, base), seconds(least),
                     bar(1e3 * wall, most=1e3 * bars[case], unit=" ms") if case in bars else ""))
    python, detect = [measured.get("start-up", case, "wall, median") for case in ("python3 -c pass", "bouncelab detect, 12 s of sound")]
    return f"""## Start

Programs started in turn, medians of {count(measured.get("start-up", "true", "runs"))} on the clock. `true` does nothing: what the system itself needs for a process. Python is what a script would start with. A detection in 12 s of sound (`samples/clean.flac`) takes {times(detect, python)} the time of `python3 -c pass`.
*HDF5 loaded*: with its libraries at the start, which bouncelab loads only where a file needs them.

""" + table(("", "wall", "over `true`", "processor", "bar"), rows)
