# SPDX-License-Identifier: GPL-3.0-or-later
"""What the functions of the package do with their keywords."""
from __future__ import annotations

import contextlib
import json
import os
import warnings
from typing import Any, Dict, Iterator, List, Mapping, Set, Tuple

from . import _core
from .progress import shown
from .results import (Analysis, BouncelabWarning, Comparison, Fit, Impacts, Loop, Onsets, Recording, Roughness, Samples,
                      Validation)


_FILE_ERROR = 3  # exit code


def _text(value: Any) -> str:
    """As the command line has it."""
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    if hasattr(value, "__iter__") and getattr(value, "ndim", 1) > 0:
        return ",".join(_text(item) for item in value)
    value = _plain(value)
    return repr(int(value) if isinstance(value, float) and value.is_integer() else value)  # 1e3 drops are 1000


def _plain(value: Any) -> Any:
    """A number or bool of NumPy as Python's."""
    return value.item() if hasattr(value, "item") and getattr(value, "ndim", 1) == 0 else value


class _Each(List[str]):
    """The values of an option that is given once for each."""


def each(values: Any) -> Any:
    """What an option takes that may be given several times: one value, or a sequence of them."""
    if values is None or isinstance(values, (str, os.PathLike)) or not hasattr(values, "__iter__"):
        return values
    return _Each(map(_text, values))


def _arguments(keywords: Dict[str, Any]) -> List[str]:
    arguments = []
    for name, value in keywords.items():
        value = _plain(value)
        option = "--" + name.replace("taken_as", "as").replace("_", "-")
        if value is None or value is False:
            continue
        if value is True:
            arguments.append(option)
        elif isinstance(value, _Each):
            arguments += [f"{option}={item}" for item in value]
        else:
            arguments.append(f"{option}={_text(value)}")
    return arguments


def _warn(lines: List[str]) -> None:
    for line in filter(None, lines):
        warnings.warn(_core.with_keywords(line), BouncelabWarning, stacklevel=4)


def simulate(keywords: Dict[str, Any], progress: Any) -> Impacts:
    with shown(progress) as callback:
        found = _core.simulate(_arguments(keywords), callback)
    _warn(found["warnings"])
    return Impacts(found["columns"], summary=json.loads(found["summary"]), world=found["world"])


def synthesize(impacts: Any, name: str, keywords: Dict[str, Any], progress: Any) -> Recording:
    impacts = Impacts.of(impacts)
    with shown(progress) as callback:
        found = _core.synthesize(impacts.to_dict(), impacts.world, name, _arguments(keywords), callback)
    return Recording(found["samples"], found["rate"], name=name, truth=Onsets(found["truth"], world=found["world"]),
                     others=found["others"], bits=keywords.get("bits") or "24")


def _is_name(recording: Any) -> bool:
    return isinstance(recording, (str, os.PathLike))


def _listed(given: Any) -> Any:
    """What is given one after the other, a generator or a Series of pandas, as a list."""
    return list(given) if hasattr(given, "__next__") or _is_series(given) else given


def detect(recording: Any, rate: Any, name: str, keywords: Dict[str, Any], progress: Any) -> Onsets:
    source: Dict[str, Any] = {}
    world: Dict[str, str] = {}  # of an array nothing is known
    recording = _listed(recording)
    with shown(progress) as callback:
        if _is_name(recording) or isinstance(recording, (list, tuple)) and recording and all(map(_is_name, recording)):
            files = [os.fspath(recording)] if _is_name(recording) else [os.fspath(file) for file in recording]
            if rate is not None:
                keywords = dict(keywords, rate=rate)
            found = _core.detect_files(files, _arguments(keywords), callback)
            world = found["world"]
        else:
            if isinstance(recording, Recording):
                world = recording.truth.world
                rate = recording.rate if rate is None else rate
                name = recording.name
                recording = recording.samples
            if recording is None or isinstance(recording, (int, float, bytes, Mapping)) or hasattr(recording, "read"):
                raise TypeError(f"{type(recording).__name__} given; the name of a file, several, or samples and their "
                                "rate are needed: detect(samples, rate)")
            if isinstance(recording, (list, tuple)) and len(recording) == 0:
                raise ValueError("no recording is given")
            if rate is None:
                raise ValueError("rate is missing: samples need their sampling rate [Hz]")
            import numpy as np

            source.update(samples=np.asarray(recording), rate=float(rate))
            found = _core.detect_samples(source["samples"], source["rate"], name, _arguments(keywords), callback)
    _warn(found["warnings"])
    return Onsets(found["columns"], summary=json.loads(found["summary"]), world=world, source=source)


def _is_series(given: Any) -> bool:
    return hasattr(given, "to_numpy") and not hasattr(given, "columns")  # of pandas


def _drops(numbers: Any) -> Any:
    """A list of drops, each a list of numbers; of one drop it may be left out."""
    numbers = numbers.to_numpy() if _is_series(numbers) else list(numbers)
    return numbers if len(numbers) > 0 and hasattr(numbers[0], "__len__") and not isinstance(numbers[0], str) else [numbers]


def _onsets(given: Any) -> Onsets:
    if isinstance(given, (list, tuple, range)) or hasattr(given, "__next__") or type(given).__name__ == "ndarray" or _is_series(given):
        import numpy as np

        drops = [np.asarray(times) for times in _drops(given)]
        if any(times.dtype.kind in "mM" for times in drops):
            raise ValueError("times are numbers of seconds: (t - t[0]) / numpy.timedelta64(1, 's')")
        drops = [times.astype(float) for times in drops]
        if any(np.any(np.diff(times) <= 0) for times in drops):
            raise ValueError("times must increase within a drop; of intervals the times are numpy.cumsum([0, *intervals])")
        return Onsets(t=np.concatenate(drops), drop=np.repeat(np.arange(len(drops)), [len(t_s) for t_s in drops]),
                      impact=np.concatenate([np.arange(len(t_s)) for t_s in drops]))
    return Onsets.of(given)


def _onsets_of_heights(heights: Any, unit: str) -> Onsets:
    drops = _drops(heights)
    # as they are printed: .81 has an error of its two digits
    return Onsets(_core.onsets_of_heights([[str(height) for height in drop] for drop in drops], unit))


def restitution(onsets: Any, heights: Any, unit: str, keywords: Dict[str, Any]) -> Samples:
    if (onsets is None) == (heights is None):
        raise ValueError("give onsets or heights")
    if heights is None and unit != "m":
        raise ValueError("unit is of heights; times are in seconds")
    onsets = _onsets(onsets) if heights is None else _onsets_of_heights(heights, unit)
    found = _core.restitution(onsets.to_dict(), onsets.world, _arguments(keywords))
    return Samples(found["columns"], summary=json.loads(found["summary"]), world=found["world"], onsets=onsets)


@contextlib.contextmanager
def _file_of_groups(groups: Any) -> Iterator[str]:
    """The name of a table of plates; of a DataFrame, a dict of columns or {recording: plate} it is written. None: empty."""
    if groups is None or _is_name(groups):
        yield "" if groups is None else os.fspath(groups)
        return
    if hasattr(groups, "to_dict") and hasattr(groups, "columns"):
        groups = groups.to_dict("list")
    if not isinstance(groups, Mapping) or ("recording" in groups and "plate" not in groups and "date" not in groups):
        raise TypeError(f"{type(groups).__name__} given; groups is a table with columns recording and plate, {{recording: plate}} "
                        "or the name of a file")
    if "recording" not in groups:
        groups = {"recording": list(groups), "plate": list(groups.values())}
    import csv
    import tempfile

    with tempfile.NamedTemporaryFile("w", prefix="groups-", suffix=".csv", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([groups, *zip(*groups.values())])
        file.flush()
        yield file.name


def fit(samples: Any, groups: Any, keywords: Dict[str, Any], progress: Any) -> Fit:
    samples = Samples.of(samples)
    with shown(progress) as callback, _file_of_groups(groups) as file:
        columns = samples.to_dict()
        text = _core.fit(columns, file, _arguments(keywords), callback)
        fitted = Fit(text, samples, keywords, _core.plates(columns, file) if file else None)
    _warn(fitted.warnings)
    return fitted


def roughness(samples: Any, keywords: Dict[str, Any], progress: Any) -> Roughness:
    with shown(progress) as callback:
        found = Roughness(json.loads(_core.roughness(Samples.of(samples).to_dict(), _arguments(keywords), callback)))
    _warn([note["text"] for note in found.results["notes"] if note["severity"] != "detail"])
    return found


class _Temporary:
    """A folder that goes with this object; a process that was forked meanwhile leaves it to the one that made it."""

    def __init__(self) -> None:
        import tempfile
        import weakref

        self.name = tempfile.mkdtemp(prefix="bouncelab-")
        self._gone = weakref.finalize(self, _remove, self.name, os.getpid())


def _remove(folder: str, process: int) -> None:
    import shutil

    if os.getpid() == process:
        shutil.rmtree(folder, ignore_errors=True)


def _folder(out: Any, name: str) -> Tuple[str, Any]:
    """The folder of the results; where none is wanted one of this name in a temporary one, which comes with it."""
    if out is not None:
        return os.fspath(out), None
    temporary = _Temporary()
    return os.path.join(temporary.name, name), temporary


def loop(out: Any, keywords: Dict[str, Any], progress: Any) -> Loop:
    folder, temporary = _folder(out, "loop")
    with shown(progress) as callback:
        found = _core.loop(_arguments(dict(keywords, out=folder)), callback)
    _warn(found["warnings"] + [found["error"]])
    return Loop(folder, json.loads(found["summary"]), temporary)


def _recordings(given: Any) -> List[str]:
    given = _listed(given)
    files = list(given) if isinstance(given, (list, tuple)) else [given]
    if not files:
        raise ValueError("no recording is given")
    for file in files:
        if not _is_name(file):
            raise TypeError(f"analyze takes files, {type(file).__name__} is given; of sound and tables in memory: "
                             "fit(restitution(detect(samples, rate)))")
    return [os.fspath(file) for file in files]


def analyze(recordings: Any, out: Any, keywords: Dict[str, Any], progress: Any) -> Analysis:
    files = _recordings(recordings)
    folder, temporary = _folder(out, "analysis")
    with shown(progress) as callback:
        found = _core.analyze(files, folder, _arguments(keywords), callback)
    summary = json.loads(found["summary"])
    if "answer" not in summary:
        error = _core.with_keywords(found["error"])
        if found["exit_code"] != _FILE_ERROR:
            raise ValueError(error)
        for file in files:  # Python says it of a file that is not there, or may not be read
            open(file, "rb").close()
        raise OSError(error)
    _warn([note["text"] for note in summary["notes"] if note["severity"] != "detail"] + [found["error"]])
    return Analysis(folder, summary, temporary)


def compare(samples: Any, out: Any, keywords: Dict[str, Any], progress: Any) -> Comparison:
    import tempfile

    seen: Set[str] = set()
    samples = _listed(samples)
    given = list(samples) if isinstance(samples, (list, tuple)) else [samples]
    if not given:
        raise ValueError("no samples are given")
    folder, temporary = _folder(out, "comparison")
    with tempfile.TemporaryDirectory(prefix="bouncelab-") as tables, _file_of_groups(keywords.get("groups")) as plates:
        files = []
        for k, table in enumerate(given, 1):
            if _is_name(table):
                files.append(os.fspath(table))
                continue
            table = Samples.of(table)
            names = [name or str(k) for name in table.get("recording", [""] * len(table))]
            names = [f"{name} ({k})" if name in seen else name for name in names]  # of an earlier table: another one
            seen.update(names)
            files.append(os.path.join(tables, f"{k}.csv"))
            Samples({**table, "recording": names}).to_csv(files[-1])
        with shown(progress) as callback:
            found = _core.compare(files, folder, _arguments(dict(keywords, groups=plates or None)), callback)
    told = found["warnings"] + [found["error"]]
    for k, file in enumerate(files, 1):
        if os.path.dirname(file) == tables:  # which the caller has never seen
            told = [line.replace(file, f"table {k}") for line in told]
    _warn(told)
    return Comparison(folder, json.loads(found["summary"]), temporary)


def dem(fit: Any, keywords: Dict[str, Any]) -> str:
    fit = fit.fit if isinstance(fit, Analysis) else fit
    return _core.dem((fit if isinstance(fit, Fit) else Fit.from_json(fit))._text, _arguments(keywords))


def _settings(vary: Dict[str, Any]) -> List[Dict[str, Any]]:
    """Those of the first recording, and what is changed in each further one."""
    lists = {name.replace("-", "_"): list(values) if hasattr(values, "__iter__") and not isinstance(values, str) else [values]
             for name, values in vary.items()}
    first = {name: values[0] for name, values in lists.items()}
    return [first, *({name: value} for name, values in lists.items() for value in values[1:])]


def validate(detector: Any, vary: Any, keywords: Dict[str, Any], progress: Any) -> Validation:
    import time

    import numpy as np

    if not callable(detector):
        raise TypeError(f"{type(detector).__name__} given; a detector is a function of samples and their rate [Hz], which gives "
                        "the times of onsets [s]")
    names = {function: {option["name"].replace("-", "_") for option in json.loads(_core.options(function))}
             for function in ("simulate", "synthesize")}
    first, *others = _settings(vary or {})
    unknown = set(first) - names["simulate"] - names["synthesize"]
    if unknown:
        raise TypeError(f"vary: '{min(unknown)}' is no keyword of validate")
    recordings, names_of = [], []
    with shown(progress) as callback:
        for k, changed in enumerate([{}, *others]):
            if callback is not None:
                callback("validate", float(k), float(1 + len(others)), "recordings")
            options = {**keywords, **first, **changed}
            sound = synthesize(simulate({n: v for n, v in options.items() if n in names["simulate"]}, None), "recording",
                               {n: v for n, v in options.items() if n in names["synthesize"]}, None)
            begin = time.process_time()
            found = detector(sound.samples, sound.rate)
            seconds = time.process_time() - begin
            t, sigma = found if isinstance(found, tuple) and len(found) == 2 else (found, None)
            if np.ndim(t) != 1:
                raise TypeError(f"the detector gave {type(t).__name__}; times of onsets [s] are needed, a list or an array, "
                                "empty where there are none, or a tuple of times and their standard errors")
            order = np.argsort(np.asarray(t, float))
            marks = {"t_s": np.asarray(t, float)[order]}
            if sigma is not None:
                marks["sigma_t_s"] = np.asarray(sigma, float)[order]
            recordings.append((sound.truth.to_dict(), marks, sound.duration, seconds))
            names_of.append(", ".join(f"{name} {value}" for name, value in changed.items()) or "all else")
    scores = json.loads(_core.score_detector(recordings))
    return Validation(scores["all"], [dict(recording=name, **score) for name, score in zip(names_of, scores["recordings"])])
