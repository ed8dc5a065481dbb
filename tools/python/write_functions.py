# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes _functions.py: the functions of the package, their keywords and documentation from the options of the command
line, as the compiled module beside the output knows them."""
import json
import os
import sys
import textwrap

OUT = sys.argv[1]
sys.path.insert(0, os.path.dirname(OUT))
import _core  # noqa: E402

# options that only choose how the program prints, and files that it writes
NOT_IN_PYTHON = {"json", "quiet", "config", "out", "labels"}
PROGRESS = ("progress", "bool or callable, optional",
            "True: a bar, where tqdm is installed. A function is called as ``progress(label, done, total, unit)``; what "
            "it raises ends the work, and so does Ctrl-C.")

KEYWORDS = {"as": "taken_as"}  # of options whose names are words of Python
OUT_FOLDER = ("out", "path", None, "Folder of the files; where absent a temporary one, which goes with the result.")

FUNCTIONS = {
    "simulate": dict(
        what="Drops a rough ball: impact times, velocities, asperities.",
        returns=("Impacts", "Ordered by drop and time."),
        call="_stages.simulate(given, progress)",
        example='''
            >>> import bouncelab as bl
            >>> impacts = bl.simulate(drops=2, impacts=5, asperities=1000)
            >>> impacts.t.shape, impacts.v.dtype
            ((10,), dtype('float64'))'''),
    "synthesize": dict(
        what="Impact times to sound: plate, sensor, noise; the exact times beside it as truth.",
        positional=[("impacts", "Impacts, mapping or path", None, "As `simulate` gives them.")],
        keywords=[("name", "str", "synthesized", "Name of the recording in tables.")],
        returns=("Recording", "Samples, rate and truth."),
        call="_stages.synthesize(impacts, name, given, progress)",
        example='''
            >>> import bouncelab as bl
            >>> impacts = bl.simulate(drops=1, impacts=5, asperities=1000)
            >>> sound = bl.synthesize(impacts, rate=22050, max_mode=10000)
            >>> sound.samples.dtype, len(sound.truth)
            (dtype('float32'), 5)'''),
    "detect": dict(
        what="Impact times of bouncing balls in sound, with standard errors; nothing has to be set.",
        positional=[
            ("recording", "path, list of paths, array or Recording", None,
             "A file (WAV, FLAC, MP3 ...; m4a, mp4 and others by ffmpeg; .npy, .csv of samples), several of them, or "
             "samples: float32 (not copied, where contiguous), full scale = 1, of one channel or (frames, channels); "
             "int16 and int32 are taken as in a WAV."),
            ("rate", "float", "None", "Sampling rate [Hz], 4e3 to 4e6: of samples, and of files of numbers without one.")],
        keywords=[("name", "str", "recording", "Of samples: name of the recording in tables.")],
        without={"rate"},
        returns=("Onsets", "Impacts of all drops of all recordings; empty where there are none: see its `message`."),
        call="_stages.detect(recording, rate, name, given, progress)",
        example='''
            >>> import bouncelab as bl
            >>> impacts = bl.simulate(drops=1, impacts=30, asperities=1000)
            >>> sound = bl.synthesize(impacts, rate=44100, max_mode=20000)
            >>> onsets = bl.detect(sound.samples, sound.rate)
            >>> len(onsets)
            30'''),
    "restitution": dict(
        what="Coefficients of restitution from impact times, ratios of neighbouring intervals, or from heights.",
        positional=[
            ("onsets", "Onsets, mapping, path, or list or array", "None",
             "The column ``t_s`` is enough. Of a list or an array: times of the impacts of one drop [s]; of several drops "
             "a list of its own for each."),
            ("heights", "list or array, or a list of them", "None",
             "In place of onsets: heights that a ball was dropped from and rose to, one after the other; a list of its "
             "own for each drop.")],
        keywords=[("unit", "str", "m", "Of heights: m, cm, mm, in or ft.")],
        returns=("Samples", "One for each impact that has one before and one after it; of heights for each bounce."),
        call="_stages.restitution(onsets, heights, unit, given)", progress=False, without={"seed", "threads"},
        example='''
            >>> import bouncelab as bl
            >>> samples = bl.restitution([0.0, 1.0, 1.9, 2.71])
            >>> samples.eps.round(12)
            array([0.9, 0.9])
            >>> bl.restitution(heights=[100, 81, 66], unit="cm").eps.round(2)
            array([0.9, 0.9])'''),
    "fit": dict(
        what="The law eps(v) and the distribution of eps about it.",
        positional=[("samples", "Samples, mapping or path", None, "Columns ``v_mps`` and ``eps`` are enough.")],
        keywords=[("groups", "DataFrame, dict or path", None,
                   "Table of columns recording and plate, as a DataFrame, a dict {recording: plate} or the name of a file: "
                   "the recordings of a plate are fitted together, and each plate has its own constants and slopes.")],
        returns=("Fit", "Curve, constants and slopes with intervals."),
        call="_stages.fit(samples, groups, given, progress)",
        example='''
            >>> import bouncelab as bl
            >>> impacts = bl.simulate(drops=3, impacts=40, asperities=100000)
            >>> samples = bl.Samples(v=impacts.v, eps=impacts.eps)
            >>> fit = bl.fit(samples, goodness_replicates=0)
            >>> bool(fit.eps(0.6).lo95 < fit.eps(0.6).value < fit.eps(0.6).hi95)
            True'''),
    "roughness": dict(
        what="The roughness of a ball from the scatter of its coefficients of restitution.",
        positional=[("samples", "Samples, mapping or path", None,
                     "Of one ball: 60 impacts or more, drops of 10 successive ones.")],
        returns=("Roughness", "The number q with its interval, and surfaces that scatter so."),
        call="_stages.roughness(samples, given, progress)",
        example='''
            >>> import bouncelab as bl
            >>> impacts = bl.simulate(drops=5, impacts=40, asperities=100000)
            >>> columns = {"drop": impacts.drop, "impact": impacts.impact, "v_mps": impacts.v, "eps": impacts.eps}
            >>> found = bl.roughness(columns, ball="steel:6mm", plate="glass", goodness_replicates=9)
            >>> bool(found.q.lo95 < found.q.value < found.q.hi95)
            True'''),
    "analyze": dict(
        what="From recordings, or times, heights or speeds, to eps(v) and a report: detect, restitution, fit in one.",
        positional=[
            ("recordings", "path or list of paths", None,
             "Sound, as `detect` takes its files, or tables of impact times, intervals, heights or speeds, and marks, of "
             "any program. Of sound in arrays: `detect`, `restitution`, `fit`.")],
        keywords=[OUT_FOLDER],
        returns=("Analysis", "Onsets, samples, fit, report."),
        call="_stages.analyze(recordings, out, given, progress)", keep={"force"},
        example='''
            >>> import bouncelab as bl
            >>> impacts = bl.simulate(drops=1, impacts=40, asperities=100000)
            >>> bl.synthesize(impacts, rate=44100, max_mode=20000).write("drop.wav")
            >>> analysis = bl.analyze("drop.wav")
            >>> len(analysis.onsets), round(analysis.fit.eps(1.0).value, 2)
            (40, 0.98)'''),
    "compare": dict(
        what="Recordings with each other: by what two differ; of many eps of all, drift, plates, outliers.",
        positional=[
            ("samples", "path, Samples, mapping or DataFrame, or list of them", None,
             "Two recordings or more: files of samples or of sound, or tables in memory, in which the column "
             "``recording`` names them; without it they are called 1, 2 ...")],
        keywords=[OUT_FOLDER],
        returns=("Comparison", "In words and numbers."),
        call="_stages.compare(samples, out, given, progress)", keep={"force"},
        example='''
            >>> import bouncelab as bl
            >>> steel, worn = (bl.simulate(drops=4, impacts=40, asperities=100000, law=law, seed=seed)
            ...                for law, seed in (("constant:0.97", 1), ("constant:0.95", 2)))
            >>> comparison = bl.compare([bl.Samples(v=i.v, eps=i.eps, drop=i.drop, impact=i.impact) for i in (steel, worn)])
            >>> [round(abs(row["eps"]["value"]), 2) for row in comparison.differences]
            [0.02]'''),
    "dem": dict(
        what="A fitted ball as input of a discrete-element code, or as a function that draws its scatter (docs/dem.md).",
        positional=[("fit", "Fit, or path of fit.json", None, "As `fit`, `analyze` and `loop` give it.")],
        returns=("str", "One impact on a plate, complete, to try and to copy from; or the function."),
        call="_stages.dem(fit, given)", progress=False, without={"seed", "threads"},
        example='''
            >>> import bouncelab as bl
            >>> impacts = bl.simulate(drops=3, impacts=40, asperities=100000)
            >>> fit = bl.fit(bl.Samples(v=impacts.v, eps=impacts.eps), goodness_replicates=0)
            >>> print(bl.dem(fit, code="lammps")[:8])
            # LAMMPS'''),
    "validate": dict(
        what="An onset detector against synthesized sound whose times are exactly known.",
        positional=[
            ("detector", "callable", None,
             "Takes samples (float32, full scale = 1; (frames, channels) for several channels) and their rate [Hz], gives "
             "the times of onsets [s], or a tuple of times and their standard errors."),
            ("vary", "dict of lists", "None",
             "Keywords and values to run through: one recording has the first of each, one each further value alone.")],
        returns=("Validation", "Scores of each recording and of all."),
        call="_stages.validate(detector, vary, given, progress)",
        example='''
            >>> import bouncelab as bl
            >>> scene = dict(drops=1, impacts=12, asperities=1000, rate=22050, max_mode=10000)
            >>> scores = bl.validate(lambda x, rate: bl.detect(x, rate).t, vary={"snr_db": [40, 20]}, **scene)
            >>> scores.all["f_1ms"], len(scores.recordings)
            (1.0, 2)'''),
    "loop": dict(
        what="The closed loop: simulate, synthesize, detect, restitution, fit, report, every stage in a folder.",
        keywords=[OUT_FOLDER],
        returns=("Loop", "What went in and what came out."),
        call="_stages.loop(out, given, progress)", keep={"force"},
        example='''
            >>> import bouncelab as bl
            >>> loop = bl.loop(drops=12, impacts=30, asperities=100000, rate=44100, max_mode=20000)
            >>> len(loop.impacts), len(loop.onsets)
            (360, 360)'''),
}
TYPES = {"INT": "int", "UINT": "int", "FLOAT": "float", "TEXT": "str", "BALL": "str", "PLATE": "str", "FILE": "path"}
HINTS = {"int": "int", "float": "float", "str": "str", "path": "Union[str, os.PathLike[str]]", "bool": "bool"}


def choices(option):
    return option["type"][len("TEXT:{"):-1].split(",") if option["type"].startswith("TEXT:{") else []


def type_of(option):
    if option["flag"]:
        return "bool"
    first = option["type"].split(":")[0]
    return TYPES.get(first, "float")  # else the form of several numbers: X,Y


def is_repeated(option):
    """Whether the option may be given several times; others take several numbers as one text, 0.1,0.2."""
    return option["most"] > 1


def is_list(option):
    return is_repeated(option) or "," in option["type"].split(":")[0]


def hint(option):
    if choices(option):
        values = [repr(choice) for choice in choices(option)] + [c for c in choices(option) if c.isdigit()]
        return f"Optional[Literal[{', '.join(values)}]]"
    kind = HINTS[type_of(option)]
    if not is_list(option):
        return f"Optional[{kind}]"
    of_one = "Union[str, Sequence[float]]" if option["name"] == "channel" else kind
    return f"Union[None, {kind}, Sequence[{of_one}]]"


def paragraph(text, indent):
    return textwrap.fill(" ".join(text.split()), 116 - len(indent), initial_indent=indent, subsequent_indent=indent,
                         break_long_words=False, break_on_hyphens=False)


def documented(option):
    if option["flag"]:
        return f"{option['keyword']} : bool, default False"
    kind = type_of(option)
    kind = f"{kind} or sequence of {kind}" if is_list(option) else kind
    if choices(option):
        kind = "{" + ", ".join(repr(choice) for choice in choices(option)) + "}"
    default = option["default"].strip("[]")
    if default in ("", "inf"):
        return f"{option['keyword']} : {kind}, optional"
    return f"{option['keyword']} : {kind}, default {default}"


def help_of(option):
    text, (_, _, limits) = _core.with_keywords(option["help"]).strip(), option["type"].partition(":")
    text = text if text[0] not in "abcdefghijklmnopqrstuvwxyz" else text[0].upper() + text[1:]
    if limits and not choices(option):
        text += f"; {limits}"
    return text if text.endswith(".") else text + "."


def function(name, spec):
    without = spec.get("without", set()) | NOT_IN_PYTHON | ({"force"} - spec.get("keep", set()))
    options = [dict(option, keyword=KEYWORDS.get(option["name"], option["name"].replace("-", "_"))) for option in json.loads(_core.options(name))
               if option["name"] not in without]
    positional, keywords = spec.get("positional", []), spec.get("keywords", [])
    arguments = [f"{key}: Any" + (f" = {default}" if default else "") for key, _, default, _ in positional] + ["*"]
    for key, kind, default, _ in keywords:
        of_one = HINTS.get(kind, "Any")
        arguments.append(f"{key}: {of_one if default else f'Optional[{of_one}]'} = {default!r}")
    for option in options:
        arguments.append(f"{option['keyword']}: " + ("bool = False" if option["flag"] else f"{hint(option)} = None"))
    if spec.get("progress", True):
        arguments.append("progress: Union[None, bool, Callback] = None")
    lines = [f"def {name}(", *(f"    {argument}," for argument in arguments), f") -> {spec['returns'][0]}:"]
    lines += [f'    """{spec["what"]}', "", "    Parameters", "    ----------"]
    for key, kind, default, help_ in positional + keywords:
        optional = ", optional" if default in (None, "None") and key not in [p[0] for p in positional[:1]] else ""
        lines += [f"    {key} : {kind}{optional}", paragraph(help_, "        ")]
    for option in options:
        lines += ["    " + documented(option), paragraph(help_of(option), "        ")]
    if spec.get("progress", True):
        lines += [f"    {PROGRESS[0]} : {PROGRESS[1]}", paragraph(PROGRESS[2], "        ")]
    lines += ["", "    Returns", "    -------", f"    {spec['returns'][0]}", paragraph(spec["returns"][1], "        ")]
    lines += ["", "    Raises", "    ------", "    ValueError", "        What is out of its range, in words."]
    lines += ["    OSError", "        A file that cannot be read or written."]
    if "example" in spec:
        lines += ["", "    Examples", "    --------", textwrap.indent(textwrap.dedent(spec["example"]).strip("\n"), "    ")]
    lines += ['    """']
    given = ", ".join(f'"{option["keyword"]}": ' + (f"_stages.each({option['keyword']})" if is_repeated(option)
                                                    else option["keyword"]) for option in options)
    lines += [textwrap.fill("given: Dict[str, Any] = {" + given + "}", 116, initial_indent="    ",
                            subsequent_indent="        ", break_long_words=False, break_on_hyphens=False)]
    lines += [f"    return {spec['call']}", ""]
    return "\n".join(lines)


text = '''# SPDX-License-Identifier: GPL-3.0-or-later
# Written by write_functions.py from the options of the command line.
"""The functions of the package."""
from __future__ import annotations

import os
from typing import Any, Dict, Literal, Optional, Sequence, Union

from . import stages as _stages
from .progress import Callback
from .results import Analysis, Comparison, Fit, Impacts, Loop, Onsets, Recording, Roughness, Samples, Validation

'''
text += "\n".join("\n" + function(name, spec) for name, spec in FUNCTIONS.items())
with open(OUT, "w", encoding="utf-8") as file:
    file.write(text)
