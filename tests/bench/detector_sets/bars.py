# SPDX-License-Identifier: GPL-3.0-or-later
"""Bars (a name, a value, a threshold) and the table of them: old beside new, all files, those to build on, those held out."""
import dataclasses
import math

from sound import part_of

PARTS = ("all", "build", "held out")


@dataclasses.dataclass(frozen=True)
class Bar:
    """`least` and `most` bound the value; a bar without either is told, not judged."""
    name: str
    value: float
    least: float = None
    most: float = None

    def met(self):
        """None: not judged, or nothing to measure (the bar on recall sees that)."""
        if self.least is None and self.most is None or math.isnan(self.value):
            return None
        return bool((self.least is None or self.value >= self.least) and (self.most is None or self.value <= self.most))

    def threshold(self):
        words = [">= %g" % self.least] if self.least is not None else []
        return " ".join(words + (["<= %g" % self.most] if self.most is not None else []))


def ratio(part, whole):
    return part / whole if whole else float("nan")


def total(records, key):
    return sum(record[key] for record in records)


def by_cell(records):
    cells = {}
    for record in records:
        cells.setdefault(record["cell"], []).append(record)
    return cells


def parts_of(records):
    return {part: [r for r in records if part in ("all", part_of(r["file"]))] for part in PARTS}


def measured(bars_of, records):
    """{part: [Bar]} of one program over one set."""
    return {part: bars_of(some) for part, some in parts_of(records).items() if some}


def cell_text(bar):
    if bar is None or math.isnan(bar.value):
        return "-"
    return ("%.4g" % bar.value) + {True: "", False: " !", None: ""}[bar.met()]


def show(title, results):
    """results: {"old": {part: [Bar]}, "new": ...}. A value that misses its bar is marked with !."""
    versions = list(results)
    names, thresholds = [], {}
    for parts in results.values():
        for bars in parts.values():
            for bar in bars:
                thresholds.setdefault(bar.name, bar.threshold())
                names += [] if bar.name in names else [bar.name]
    print("\n## " + title)
    heads = ["%s %s" % (version, part.split()[0]) for part in PARTS for version in versions]
    print("%-54s %-14s" % ("bar", "threshold") + "".join("%12s" % head for head in heads))
    for name in names:
        line = "%-54s %-14s" % (name, thresholds[name])
        for part in PARTS:
            for version in versions:
                line += "%12s" % cell_text(next((b for b in results[version].get(part, []) if b.name == name), None))
        print(line)


def as_json(results):
    return {version: {part: [dict(dataclasses.asdict(bar), met=bar.met()) for bar in bars] for part, bars in parts.items()}
            for version, parts in results.items()}
