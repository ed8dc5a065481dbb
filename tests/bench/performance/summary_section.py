# SPDX-License-Identifier: GPL-3.0-or-later
"""Section of the page: the bars in one table, beside the best of the baselines."""
from measured import bar, number, over, seconds, table, times

SCIPY = "SciPy's trigger + stack + correlation"
LARGE = "constant:0.001, N = 1000000"


def rows(measured):
    get = measured.get
    for what, most in (("wall", 20), ("processor", 40)):
        value = get("loop", "paper", f"whole command, {what}")
        yield f"the paper's loop without the fits with memory, {what}", value, seconds(value), times(get("loop", "paper", "sound"), value) + " real time", bar(value, most=most, unit=" s")
    for rate, least in ((44100, 2500), (96000, 1500)):
        case = f"drops, {rate} Hz"
        ours = get("detect", case, "bouncelab")
        value = over(get("detect", case, "sound"), ours)
        peers = f"{times(get('detect', case, 'aubioonset'), ours)} aubioonset, {times(get('detect', case, SCIPY), ours)} SciPy"
        yield f"detect, {rate / 1000:g} kHz, one thread", value, number(value) + " × real time", peers, bar(value, least=least, unit=" ×")
    kinds = {case: get("detect", case, "sound") / get("detect", case, "bouncelab") for case in measured.cases("detect", "without a ball")}
    slowest = min(kinds, key=kinds.get, default=None)
    value = kinds.get(slowest)
    yield "detect, the slowest sound without a ball", value, number(value) + " × real time", slowest and slowest.removeprefix("without a ball: "), bar(value, least=200, unit=" ×")
    direct, ours = [get("synthesize", "96000 Hz", what) for what in ("direct sum", "one point a drop")]
    yield "synthesize, 96 kHz, one thread", ours, number(over(1, ours)) + " × real time", times(direct, ours) + " the direct sum", ""
    impact, smooth = [get("simulate", LARGE, what) for what in ("impact", "impact of the smooth ball")]
    value = over(impact, smooth)
    yield ("simulate, 10⁶ equal asperities", value, f"{number(value)} × the smooth ball's impact", times(get("simulate", LARGE, "impact by brute force"), impact) + " brute force",
           bar(value, most=4, unit=" ×"))
    value = get("simulate", LARGE, "envelope")
    yield "envelope of that ball", value, seconds(value), "", bar(value, most=1.5, unit=" s")
    case = next((c for c in measured.cases("fit") if "0.2 of the scatter" in c), "")
    ours = get("fit", case, "law with profile intervals")
    yield "fit, " + case.split(",")[0], ours, seconds(ours), times(get("fit", case, "iminuit, profile intervals"), ours) + " iminuit", ""
    for case, name, most in (("bouncelab --version", "start", 5), ("bouncelab detect, 12 s of sound", "detect, 12 s of sound", 12)):
        value = get("start-up", case, "wall, median")
        peer = times(get("start-up", "python3 -c pass", "wall, median"), value) + " `python3 -c pass`"
        yield name, value, seconds(value), peer, bar(None if value is None else 1e3 * value, most=most, unit=" ms")


def summary(measured):
    known = [(what, text, peer, judged) for what, value, text, peer, judged in rows(measured) if value is not None]
    if not known:
        return ""
    return """## In short

Speed *against* others: how many times as long they take.

""" + table(("", "bouncelab", "against", "bar"), known)
