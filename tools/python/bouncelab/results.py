# SPDX-License-Identifier: GPL-3.0-or-later
"""What the functions give back: tables of arrays, and fits."""
from __future__ import annotations

import copy
import json
import os
import warnings
from typing import TYPE_CHECKING, Any, Dict, Iterator, List, Mapping, NamedTuple, Optional, Union

from . import _core

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    import pandas as pd

    Array = npt.NDArray[np.float64]
    Path = Union[str, "os.PathLike[str]"]


_ROUNDING, _ONE_SPEED = 1e-9, 0.1  # in ln v: so near the ends, or the only speed


class BouncelabWarning(UserWarning):
    """What the command line prints as a warning."""


class Estimate(NamedTuple):
    """A value with its standard error and 95 % interval, NaN where they are not known; numbers, or arrays."""

    value: Any
    se: Any
    lo95: Any
    hi95: Any


def _counted(n: int, noun: str) -> str:
    return f"{n} {noun}{'' if n == 1 else 's'}"


def _estimate(found: Mapping[str, Any], value: str = "value") -> Estimate:
    lo, hi = found["ci95"] or (None, None)
    return Estimate(*(float("nan") if x is None else x for x in (found[value], found["se"], lo, hi)))


def _speeds(v: npt.ArrayLike) -> Array:
    import numpy as np

    speeds = np.asarray(v, dtype=float)
    if not np.all((speeds > 0) & np.isfinite(speeds)):
        raise ValueError("v: speeds must be finite and > 0 [m/s]")
    return speeds


def _array(values: Any) -> Any:
    """A column as an array; what is masked is missing: NaN, in texts empty."""
    import numpy as np

    if not np.ma.isMaskedArray(values):
        return np.asarray(values)
    is_number = values.dtype.kind in "fiub"
    return values.astype(float if is_number else object).filled(np.nan if is_number else "") if np.ma.is_masked(values) else values.data


class Table(Mapping[str, Any]):
    """Columns by name, each a NumPy array; the names and units of docs/formats.md.

    Parameters
    ----------
    columns : mapping, optional
        Arrays by the names of their columns; those with short names may be given as keywords (``t=``, ``v=``).
    """

    _kind = ""
    _short: Dict[str, str] = {}

    def __init__(self, columns: Optional[Mapping[str, Any]] = None, *, summary: Optional[dict] = None,
                 world: Optional[Mapping[str, str]] = None, **arrays: Any):
        self._columns: Dict[str, Any] = {self._short.get(name, name): _array(values) for name, values in (columns or {}).items()}
        for name, values in arrays.items():
            if name not in self._short and name not in self._short.values():
                raise TypeError(f"{type(self).__name__} has no column '{name}'; it has {', '.join(self._short)}")
            self._columns[self._short.get(name, name)] = _array(values)
        #: What the command prints with --json.
        self.summary: dict = summary or {}
        #: What is known of how the impacts came about, by the options of `simulate`: ball, plate, asperities, drag, gravity.
        #: Files have it in their .meta.json.
        self.world: Dict[str, str] = dict(world or {})

    @classmethod
    def of(cls, values: Any) -> Any:
        """`values` itself, or the table of its columns: a mapping, a DataFrame, or the name of a file."""
        if isinstance(values, cls):
            return values
        if isinstance(values, (str, os.PathLike)):
            return cls.from_csv(values)
        if cls is Samples and isinstance(values, Onsets):
            raise TypeError("Onsets given; Samples are needed: restitution(onsets)")
        if cls is Samples and hasattr(values, "keys") and {"v_after_mps", "eps"}.intersection(values) == {"v_after_mps"}:
            raise TypeError("Impacts given; Samples are needed: restitution(impacts)")
        if hasattr(values, "columns") and hasattr(values, "to_numpy"):  # pandas
            return cls({name: values[name].to_numpy() for name in values.columns})
        if isinstance(values, Mapping):
            return cls(values, world=getattr(values, "world", None))
        if cls is Samples and isinstance(values, Analysis):
            return values.samples
        raise TypeError(f"{type(values).__name__} given; {cls.__name__}, columns by name or the name of a file are needed")

    @classmethod
    def from_csv(cls, path: Path, *, taken_as: str = "auto", unit: str = "auto", columns: str = "",
                 tier: str = "") -> Any:
        """Reads a table as the command line writes it (.csv); as `Onsets` also marks of sound editors and
        times or intervals of any program, as `Samples` also speeds and coefficients from elsewhere. What such a file
        was taken for is in ``summary["taken_for"]``; where it does not prove that, a ValueError has the question and the
        keywords of each answer.

        Parameters
        ----------
        path : str or path
            The file.
        taken_as : {"auto", "times", "intervals", "heights"}
            What the numbers of a table from elsewhere are.
        unit : {"auto", "s", "ms", "us", "m", "cm", "mm", "in", "ft"}
            Their unit.
        columns : str
            Which of its columns are what, by title or number from 1: "t=COLUMN", "h=COLUMN" or "h0=COLUMN,h=COLUMN" of
            heights; as `Samples` "v=COLUMN,eps=COLUMN" or "v_in=COLUMN,v_out=COLUMN".
        tier : str
            Tier of a TextGrid, layer of an .svl, by name or number.
        """
        found, taken_for, world = _core.read_columns(os.fspath(path), cls._kind, taken_as, unit, columns, tier)
        return cls(found, summary={"taken_for": taken_for} if taken_for else None, world=world)

    def to_csv(self, path: Path, force: bool = False) -> None:
        """Writes the table as the command line does, whole or not at all, and its world beside it (.meta.json).

        Parameters
        ----------
        path : str or path
            .csv.
        force : bool, default False
            Replace a file that exists.
        """
        _core.write_columns(os.fspath(path), self._columns, self._kind, self.world, force)

    def to_dict(self) -> Dict[str, Any]:
        """The arrays by the names of their columns; not copied."""
        return dict(self._columns)

    def to_pandas(self) -> pd.DataFrame:
        """A DataFrame with the same columns."""
        import pandas as pd

        return pd.DataFrame(self._columns)

    def __getitem__(self, name: Any) -> Any:
        """A column by its name; by a slice, numbers or a mask of rows a table of these."""
        if isinstance(name, str):
            column = self._short.get(name, name)
            if column not in self._columns:
                raise KeyError(f"{name!r}: no such column; there are {', '.join(self._columns) or 'none'}")
            return self._columns[column]
        if not isinstance(name, slice) and not hasattr(name, "__len__"):
            raise KeyError(f"{name!r}: the name of a column, a slice or a mask of rows")
        import numpy as np

        rows = name if isinstance(name, slice) else np.asarray(name)
        some = copy.copy(self)
        some._columns = {column: np.asarray(values)[rows] for column, values in self._columns.items()}
        return some

    def __eq__(self, other: Any) -> Any:
        """Whether type, columns and rows are the same; NaN is NaN."""
        if type(self) is not type(other):
            return NotImplemented
        import numpy as np

        return list(self) == list(other) and all(
            np.array_equal(values, other[name], equal_nan=np.asarray(values).dtype.kind == "f") for name, values in self.items())

    __hash__ = None  # type: ignore[assignment]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        """Number of rows."""
        return len(next(iter(self._columns.values()), ()))

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name not in self._short:
            raise AttributeError(f"'{type(self).__name__}' has no attribute '{name}'; its columns are {', '.join(self._short)}")
        try:
            return self._columns[self._short[name]]
        except KeyError:
            raise AttributeError(f"these {self._kind} have no column {self._short[name]}") from None

    def __setattr__(self, name: str, value: Any) -> None:
        if name in self._short or name in self._short.values():
            raise AttributeError(f"columns are not assigned: table['{name}'][:] = ... changes one in place, {type(self).__name__}({{**table, "
                                 f"'{name}': ...}}, world=table.world) is a table with another")
        super().__setattr__(name, value)

    def __dir__(self) -> List[str]:
        return sorted({*super().__dir__(), *self._short})

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {_counted(len(self), 'row')} of {', '.join(self._columns) or 'no column'}>"

    def _repr_html_(self) -> str:
        from .notebook import table_html

        return table_html(self)


class Impacts(Table):
    """Impacts of simulated drops: drop, impact, t [s] from the release, v and v_after [m/s], eps, asperity."""

    _kind = "impacts"
    _short = {"drop": "drop", "impact": "impact", "t": "t_s", "v": "v_mps", "v_after": "v_after_mps",
              "eps": "eps_macro", "v_contact": "v_contact_mps", "eps_contact": "eps_contact", "asperity": "asperity"}


class Onsets(Table):
    """Impacts as found in sound: t [s] from the first sample, its standard error sigma [s], drop and impact, amplitude
    (full scale = 1), snr [dB], flags, probability, recording."""

    _kind = "onsets"
    _short = {"recording": "recording", "drop": "drop", "impact": "impact", "t": "t_s", "sigma": "sigma_t_s",
              "amplitude": "amplitude", "snr": "snr_db", "flags": "flags", "probability": "probability"}

    def __init__(self, columns: Optional[Mapping[str, Any]] = None, *, summary: Optional[dict] = None,
                 world: Optional[Mapping[str, str]] = None, source: Optional[dict] = None, **arrays: Any):
        super().__init__(columns, summary=summary, world=world, **arrays)
        self._source = source or {}

    @property
    def message(self) -> str:
        """What was found, or why nothing was: a line for each recording."""
        return "\n".join(_core.with_keywords(f"{r['recording']}: {r['message']}") for r in self.summary.get("recordings", []))

    def _wave_json(self) -> str:
        """Envelope and excerpts of the first recording, for a report; empty where its sound is not there."""
        first = next((r for r in self.summary.get("recordings", []) if r.get("n_impacts", r.get("n_onsets", 0))), None)
        if first is None or len(self) == 0:
            return ""
        name, channel = first["recording"], first.get("channel", 0)
        if "samples" in self._source:
            return _core.wave_of_samples(self._source["samples"], self._source["rate"], name, channel, self._columns)
        return _core.wave_of_file(name, channel, self._columns, 0.0, first.get("track", 0)) if os.path.exists(name) else ""


class Samples(Table):
    """Coefficients of restitution: v [m/s], eps, its standard error sigma from the timing alone, t [s], drop, impact,
    recording, flags."""

    _kind = "samples"
    _short = {"recording": "recording", "drop": "drop", "impact": "impact", "t": "t_s", "v": "v_mps", "eps": "eps",
              "sigma": "sigma_eps", "sigma_v": "sigma_v_mps", "flags": "flags"}

    def __init__(self, columns: Optional[Mapping[str, Any]] = None, *, summary: Optional[dict] = None,
                 world: Optional[Mapping[str, str]] = None, onsets: Optional[Onsets] = None, **arrays: Any):
        super().__init__(columns, summary=summary, world=world, **arrays)
        #: The onsets that they were computed from, where there were any.
        self.onsets: Optional[Onsets] = onsets


class Recording:
    """Sound that was synthesized.

    Attributes
    ----------
    samples : ndarray of float32
        Full scale = 1; (frames,) or (frames, channels).
    rate : int
        Sampling rate [Hz].
    truth : Onsets
        True times, and Cramér-Rao bounds in place of standard errors.
    others : dict
        Other sounds, ``kind`` and ``t_s``.
    """

    def __init__(self, samples: Any, rate: int, *, name: str, truth: Onsets, others: Dict[str, Any], bits: str):
        self.samples, self.rate, self.name, self.truth, self.others = samples, rate, name, truth, others
        self._bits = str(bits)

    @property
    def duration(self) -> float:
        """Length [s]."""
        return len(self.samples) / self.rate

    def write(self, path: Path, force: bool = False) -> None:
        """Writes the sound: .wav, .flac, .w64 or .rf64, with the bits that it was made with; what is known of its ball
        beside it (.meta.json).

        Parameters
        ----------
        path : str or path
            File to write.
        force : bool, default False
            Replace a file that exists.
        """
        _core.write_sound(os.fspath(path), self.samples, self.rate, self._bits, self.truth.world, force)

    def __repr__(self) -> str:
        return f"<Recording {self.name}: {self.duration:.1f} s at {self.rate} Hz, {_counted(len(self.truth), 'impact')}>"

    def _repr_html_(self) -> str:
        from .notebook import recording_html

        return recording_html(self)


class Fit:
    """The curve eps(v), the constants of the law and the distribution of eps: everything of fit.json.

    Parameters
    ----------
    text : str
        fit.json as the command line writes it, too.
    samples : Samples, optional
        What was fitted; few samples are shown one by one in pictures and reports.
    keywords : dict, optional
        Those that it was made with.
    plates : dict, optional
        The plate of each recording.
    """

    def __init__(self, text: str, samples: Optional[Samples] = None, keywords: Optional[Dict[str, Any]] = None,
                 plates: Optional[Dict[str, str]] = None):
        self._text = text
        self._keywords, self._plates = keywords or {}, plates or {}
        #: fit.json as a dict (docs/formats.md).
        self.results: dict = json.loads(text)
        if "scatter" not in self.results:
            raise ValueError("this fit.json was written by bouncelab 0.2 or before, whose eps was another; "
                             "make it anew: bouncelab fit samples.csv --out fit.json")
        self.samples: Optional[Samples] = samples

    @classmethod
    def from_json(cls, path: Path) -> Fit:
        """Reads fit.json."""
        with open(path, encoding="utf-8") as file:
            text = file.read()
        try:
            return cls(text)
        except ValueError as error:
            raise ValueError(f"{os.fspath(path)}: {error}") from None

    def __getattr__(self, name: str) -> Any:
        if name == "law":
            raise AttributeError("Fit.law went with 0.3: the curve is eps(v) and results['curve'], the constants of the "
                                 "law are results['constants']")
        raise AttributeError(f"'{type(self).__name__}' object has no attribute '{name}'")

    @property
    def status(self) -> str:
        """Of the constants: ``ok``, ``not_identifiable`` (the curve is known, A2, A4, A5 are not), ``not_applicable``
        (the law does not describe the samples, the curve does), or why there are none."""
        return self.results["constants"]["status"]

    @property
    def warnings(self) -> List[str]:
        """What to know before use, most important first."""
        return [_core.with_keywords(note["text"]) for note in self.results["notes"] if note["severity"] != "detail"]

    @property
    def answer(self) -> str:
        """The result in a few sentences."""
        return _core.with_keywords("\n".join(self.results["answer"]["sentences"]))

    @property
    def parameters(self) -> Dict[str, Estimate]:
        """A2, A4, A5 ... (or gamma, or eps) with standard errors and 95 % intervals; empty where the law does not describe
        the samples."""
        constants = self.results["constants"]
        return {name: _estimate(constants[name]) for name in constants["parameters"]}

    @property
    def slopes(self) -> List[Dict[str, Any]]:
        """The two exponentials of p(eps), a dict for each window of speed as in ``results["histograms"]``: of all samples,
        where they have one answer, then of each recording or plate (``recording``)."""
        of_all = [("", self.results["histograms"])] if self.results["is_one_ball"] else []
        rows = of_all + [(row["recording"], row["slopes"]) for row in self.results["recordings"]]
        names = ("v_mps", "n", "peak_eps", "slope_rising", "slope_falling", "slope_ratio")
        return [dict({name: window[name] for name in names}, recording=recording) for recording, windows in rows for window in windows]

    @property
    def recordings(self) -> List[Dict[str, Any]]:
        """Each recording alone, or each plate where there are ``groups``, a dict for each (``pandas.DataFrame(fit.recordings)``):
        ``recording``, at the speed ``v_mps`` that is common to most ``eps`` with ``se``, ``lo95`` and ``hi95``; ``n`` samples
        of ``n_drops``; ``missing`` says why eps is NaN. `of` has the whole curve."""
        answer = self.results["answer"]
        rows = [{"recording": row["recording"], "at": answer_of["at"], "n": row["n"], "n_drops": row["n_drops"],
                 "missing": _core.with_keywords(answer_of["missing"])}
                for row, answer_of in zip(self.results["recordings"], answer["recordings"])]
        if not rows:  # there is one
            names = [] if self.samples is None else list(self.samples.get("recording", ()))[:1]
            rows = [{"recording": self._plates.get(*names * 2) if names else "", "at": answer["at"],
                     "n": self.results["n_used"], "n_drops": answer["seen"]["n_drops"],
                     "missing": "" if answer["at"] else self._why()}]
        for row in rows:
            at = row.pop("at")
            value, se, lo95, hi95 = _estimate(at, "eps") if at else [float("nan")] * 4
            row.update(v_mps=at["v_mps"] if at else float("nan"), eps=value, se=se, lo95=lo95, hi95=hi95)
        order = ("recording", "v_mps", "eps", "se", "lo95", "hi95", "n", "n_drops", "missing")
        return [{name: row[name] for name in order} for row in rows]

    def of(self, recording: str) -> Fit:
        """The fit of one recording alone, or of one plate where there are ``groups``: of its samples, with the same keywords.

        Parameters
        ----------
        recording : str
            Its name, as in `recordings`.

        Returns
        -------
        Fit
            As `bouncelab.fit` of these samples alone gives it.
        """
        names = [row["recording"] for row in self.recordings]
        if recording not in names:
            raise KeyError(f"{recording!r}: the fit is of {', '.join(map(repr, names))}")
        if len(names) == 1:
            return self
        if self.samples is None:
            raise ValueError("the samples are needed, which fit.json has not: fit them anew")
        from .stages import fit

        rows = [self._plates.get(name, name) == recording for name in self.samples["recording"]]
        return fit(self.samples[rows], None, self._keywords, None)

    @property
    def nodes(self) -> Dict[float, Estimate]:
        """eps(v), the root mean square over bounces, by the speeds [m/s] at which it is reported; empty without a curve.
        The mean and the peak are in ``results["curve"]``."""
        curve = self.results["curve"]
        return {node["v_mps"]: _estimate(node, "eps") for node in curve["nodes"]} if curve else {}

    @property
    def law_text(self) -> str:
        """The law with its constants as the options ``--law`` and ``law=`` take it: of the peak of the distribution."""
        values = {name: estimate.value for name, estimate in self.parameters.items()}
        if not values:
            raise ValueError(f"the fit has no law ({self.status}): {self._why()}")
        kind = {"gamma": "viscoelastic", "eps": "constant"}.get(next(iter(values)), "series")
        if kind == "series":
            return "series:" + ",".join(f"{name}={value!r}" for name, value in values.items())
        return f"{kind}:{next(iter(values.values()))!r}"

    def eps(self, v: npt.ArrayLike) -> Estimate:
        """The root mean square of eps over bounces at these speeds: its square is the energy that a bounce keeps.

        Parameters
        ----------
        v : array_like
            Normal impact speeds [m/s], > 0.

        Returns
        -------
        Estimate
            Value, standard error and 95 % interval: numbers, or arrays of the shape of `v`. Between the points of
            fit.json's curve straight in ln v; NaN outside the speeds of the data, of one speed more than a tenth off it.
        """
        import numpy as np

        if not self.results.get("is_one_ball", True):
            warnings.warn("recordings, plates or drops differ: this is the curve of all together; each has its own eps in "
                          "results['recordings']", BouncelabWarning, stacklevel=2)
        speeds = _speeds(v)
        x, points = self._points()
        near = _ROUNDING if len(x) > 1 else _ONE_SPEED
        beyond = (np.log(speeds) < x[0] - near) | (np.log(speeds) > x[-1] + near)
        value, lo95, hi95 = (np.where(beyond, np.nan, np.interp(np.log(speeds), x, y)) for y in points)
        estimate = Estimate(value, (hi95 - lo95) / (2 * 1.959963984540054), lo95, hi95)
        return Estimate(*map(float, estimate)) if speeds.ndim == 0 else estimate

    def _why(self) -> str:
        """Why there are no constants, or no fit."""
        kinds = ("law_contradicted", "too_few_samples", "not_a_sphere", "not_converged", "not_identifiable")
        return _core.with_keywords("; ".join(note["text"] for note in self.results["notes"] if note["kind"] in kinds))

    def _points(self) -> Any:
        """ln v of the points of the curve; eps, lo95 and hi95 there. Of one speed alone its node."""
        import numpy as np

        curve = self.results["curve"]
        if curve is None:
            raise ValueError(f"the fit has no curve ({self.status}): {self._why()}")
        points = curve["points"] or [{**node, "lo95": node["ci95"][0], "hi95": node["ci95"][1]} for node in curve["nodes"]]
        return np.log([p["v_mps"] for p in points]), [np.array([p[key] for p in points]) for key in ("eps", "lo95", "hi95")]

    def sample(self, v: npt.ArrayLike, n: Optional[int] = None, rng: Union[None, int, np.random.Generator] = None) -> Array:
        """Coefficients of restitution as they scatter, for simulations: two exponentials and a normal, whose root mean
        square is the curve. Beyond the speeds of the data they are those at its ends.

        Parameters
        ----------
        v : array_like
            Normal impact speeds [m/s], > 0.
        n : int, optional
            Draws for each speed; one without a further dimension where absent.
        rng : numpy.random.Generator or int, optional
            Source of random numbers, or its seed; a new one where absent.

        Returns
        -------
        ndarray
            Of the shape of `v`, or (n, *shape of `v`). Independent of each other: what a ball's earlier impacts have
            stored in spin (docs/physics.md, 7) is not known here.
        """
        import numpy as np

        scatter = self.results["scatter"]
        if scatter is None:
            raise ValueError(f"the fit has no model of the scatter ({self.status})")
        rng = np.random.default_rng(rng)
        x, (rms, _, _) = self._points()
        speeds = np.clip(_speeds(v), np.exp(x[0]), np.exp(x[-1]))
        below, above, normal, _ = _core.scatter(
            scatter["v_ref_mps"], scatter["log_below"], scatter["log_above"], scatter["normal_ratio"], speeds)
        shape = speeds.shape if n is None else (n, *speeds.shape)
        mean = np.sqrt(np.maximum(0.0, np.interp(np.log(speeds), x, rms) ** 2 - below**2 - above**2 - normal**2))
        # the difference of two exponentials has the density of both sides, joined at its peak
        drawn = above * rng.exponential(size=shape) - below * rng.exponential(size=shape)
        drawn += normal * rng.standard_normal(size=shape)
        return mean - (above - below) + drawn

    def shown_samples(self) -> Optional[Dict[str, np.ndarray]]:
        """The samples without the drag and contact time that the fit found: ``v_mps``, ``eps``, ``sigma_eps`` (NaN where it
        is not known). None where there are none, or more than 400."""
        text = _core.shown_samples(self.samples.to_dict(), self._text) if self.samples is not None else ""
        if not text:
            return None
        import numpy as np

        shown = json.loads(text)
        return {name: np.array(shown[name], float) for name in ("v_mps", "eps", "sigma_eps")}

    def report(self, path: Path, title: Optional[str] = None, force: bool = False) -> None:
        """Writes a report, one HTML file that needs no network.

        Parameters
        ----------
        path : str or path
            File to write.
        title : str, optional
            Heading; the recording's name where absent.
        force : bool, default False
            Replace a file that exists.
        """
        onsets = self.samples.onsets if self.samples is not None else None
        if title is None:
            recordings = [] if onsets is None else onsets.summary.get("recordings", [])
            title = "Restitution from " + os.path.basename(recordings[0]["recording"]) if recordings else "Restitution"
        _core.write_report(os.fspath(path), title, self._text, "" if onsets is None else onsets._wave_json(),
                           {} if self.samples is None else self.samples.to_dict(), force)

    def to_dict(self) -> dict:
        """fit.json as a dict."""
        return self.results

    def to_pandas(self) -> pd.DataFrame:
        """The speeds reported and the constants, a row each: value, se, lo95, hi95."""
        import pandas as pd

        rows = {f"eps({v:g} m/s)": estimate for v, estimate in self.nodes.items()}
        rows.update(self.parameters)
        return pd.DataFrame.from_dict(rows, orient="index", columns=list(Estimate._fields))

    def __repr__(self) -> str:
        return f"<Fit ({self.status}): {self.results['answer']['sentences'][0] if self.answer else self._why()}>"

    def _repr_html_(self) -> str:
        from .notebook import fit_html

        return fit_html(self)


class Roughness:
    """The roughness of a ball from how its coefficients of restitution scatter.

    Attributes
    ----------
    results : dict
        What ``bouncelab roughness --json`` prints.
    """

    def __init__(self, results: dict):
        self.results = results

    def _why(self) -> str:
        return _core.with_keywords(
            "; ".join(note["text"] for note in self.results["notes"] if note["kind"].startswith("memory_")))

    @property
    def holds(self) -> bool:
        """Whether the scatter is that of a rough ball; otherwise q means nothing."""
        return self.results["holds"]

    @property
    def q(self) -> Estimate:
        """q = c s2, s2 the mean square offset of the contact over the ball's radius, each component."""
        found = self.results["roughness"]
        if found is None:
            raise ValueError(self._why())
        return _estimate({"q": found["q"], "se": found["q_se"], "ci95": found["q_ci95"]}, "q")

    def to_dict(self) -> dict:
        """What ``bouncelab roughness --json`` prints."""
        return self.results

    def __repr__(self) -> str:
        if self.results["roughness"] is None:
            return f"<Roughness: {self._why()}>"
        return f"<Roughness: q = {self.q.value:.3g} ± {self.q.se:.2g}{'' if self.holds else ', does not hold'}>"


class _Folder:
    """Files that a stage has written.

    Attributes
    ----------
    folder : str
        Where the files lie; a temporary folder goes with this object.
    summary : dict
        What the command prints with --json.
    """

    def __init__(self, folder: str, summary: dict, temporary: Any = None):
        self.folder, self.summary, self._temporary = folder, summary, temporary

    def __getstate__(self) -> dict:
        if self._temporary is not None:
            raise TypeError(f"of a temporary folder no {type(self).__name__} can be copied or pickled: name a folder "
                            "(out=...), or take its fit, samples, onsets")
        return self.__dict__

    def path(self, name: str) -> str:
        """Of a file in the folder."""
        return os.path.join(self.folder, name)

    @property
    def report(self) -> str:
        """Path of the report."""
        return self.path("report.html")


class Analysis(_Folder):
    """Recordings, or times, heights or speeds, analyzed: files in a folder.

    Attributes
    ----------
    folder : str
        Where the files lie; a temporary folder goes with this object.
    summary : dict
        summary.json: impacts, drops, answer, notes.
    """

    @property
    def onsets(self) -> Onsets:
        """Times found in the sound, or given; none where speeds were given."""
        return Onsets.from_csv(self.path("onsets.csv")) if os.path.exists(self.path("onsets.csv")) else Onsets()

    @property
    def samples(self) -> Samples:
        """Coefficients of restitution from these times."""
        return Samples.from_csv(self.path("samples.csv"))

    @property
    def fit(self) -> Fit:
        """Fitted to them."""
        fit = Fit.from_json(self.path("fit.json"))
        fit.samples = self.samples
        return fit

    def __repr__(self) -> str:
        return f"<{type(self).__name__} in {self.folder}: {self.fit!r}>"

    def _repr_html_(self) -> str:
        return self.fit._repr_html_()


class Loop(Analysis):
    """The closed loop: files of every stage in a folder.

    Attributes
    ----------
    folder : str
        Where the files lie; a temporary folder goes with this object.
    summary : dict
        summary.json: what went in and what came out.
    """

    @property
    def impacts(self) -> Impacts:
        """As simulated."""
        return Impacts.from_csv(self.path("impacts.csv"))

    @property
    def truth(self) -> Onsets:
        """True times in the recording."""
        return Onsets.from_csv(self.path("truth.csv"))

    def __repr__(self) -> str:
        score = self.summary["score"]
        return f"<Loop in {self.folder}: {score['n_found']} of {score['n_true']} impacts found>"


class Comparison(_Folder):
    """Recordings compared with each other: files in a folder.

    Attributes
    ----------
    folder : str
        Where the files lie; a temporary folder goes with this object.
    results : dict
        comparison.json (docs/formats.md).
    """

    @property
    def results(self) -> dict:
        """comparison.json (docs/formats.md)."""
        return self.summary

    @property
    def answer(self) -> str:
        """The result in a few sentences."""
        return _core.with_keywords("\n".join(self.results["answer"]))

    @property
    def differences(self) -> List[Dict[str, Any]]:
        """Of plates, or of two to four recordings: by what each two differ, a dict for each pair."""
        return (self.results["differences"] or {"rows": []})["rows"]

    @property
    def recordings(self) -> List[Dict[str, Any]]:
        """comparison.csv, a dict for each recording; None where a cell is empty."""
        import csv

        texts = ("recording", "plate", "date", "message")
        with open(self.path("comparison.csv"), encoding="utf-8", newline="") as file:
            return [{name: cell if name in texts else json.loads(cell or "null") for name, cell in row.items()}
                    for row in csv.DictReader(file)]

    def to_dict(self) -> dict:
        """comparison.json as a dict."""
        return self.results

    def to_pandas(self) -> pd.DataFrame:
        """A row for each recording."""
        import pandas as pd

        return pd.DataFrame(self.recordings)

    def __repr__(self) -> str:
        return f"<Comparison of {_counted(len(self.recordings), 'recording')}: {self.results['answer'][0]}>"


class Validation:
    """How well an onset detector agrees with the true times of synthesized recordings.

    Attributes
    ----------
    all : dict
        Scores of all recordings together, by the names of docs/validation.md.
    recordings : list of dict
        Those of each, with ``recording``: in what it differs from the first.
    """

    def __init__(self, all: Dict[str, Any], recordings: List[Dict[str, Any]]):
        self.all, self.recordings = all, recordings

    def to_dict(self) -> dict:
        """Both, by name."""
        return {"all": self.all, "recordings": self.recordings}

    def to_pandas(self) -> pd.DataFrame:
        """A row for each recording."""
        import pandas as pd

        return pd.DataFrame(self.recordings)

    def __repr__(self) -> str:
        return f"<Validation over {_counted(len(self.recordings), 'recording')}: F {self.all['f_50ms']} at 50 ms, {self.all['f_1ms']} at 1 ms>"
