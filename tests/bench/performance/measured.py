# SPDX-License-Identifier: GPL-3.0-or-later
"""The numbers of a run by part, case and name, and how they are written in a table."""
import math


class Measured:
    def __init__(self, lines):
        self.values = {(line["part"], line["case"], line["what"]): line["value"] for line in lines}
        self.units = {(line["part"], line["case"], line["what"]): line["unit"] for line in lines}

    def get(self, part, case, what):
        """None where it was not measured."""
        return self.values.get((part, case, what))

    def unit(self, part, case, what):
        return self.units[part, case, what]

    def has(self, part):
        return any(key[0] == part for key in self.values)

    def cases(self, part, beginning=""):
        return list(dict.fromkeys(case for p, case, _ in self.values if p == part and case.startswith(beginning)))

    def names(self, part, case):
        return [what for p, c, what in self.values if p == part and c == case]


def number(value, digits=3):
    """Three significant digits, thousands separated."""
    if value is None or not math.isfinite(value):
        return "not measured"
    if value == 0:
        return "0"
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    return f"{round(value, digits - 1 - math.floor(math.log10(abs(value)))):,.{decimals}f}"


def count(value):
    return "not measured" if value is None else f"{round(value):,}"


def with_unit(value, unit, factors):
    """In the largest unit of which there is one at least. @param factors  {name: size}, from large to small"""
    if value is None:
        return "not measured"
    name, size = next(((n, s) for n, s in factors.items() if abs(value) >= s), list(factors.items())[-1])
    return f"{number(value / size)} {name}{unit}"


def seconds(value):
    return with_unit(value, "s", {"": 1.0, "m": 1e-3, "µ": 1e-6, "n": 1e-9})


def size(value):
    return with_unit(value, "B", {"G": 1e9, "M": 1e6, "k": 1e3, "": 1.0})


def over(a, b):
    return None if a is None or b is None or b == 0 else a / b


def times(a, b):
    """a / b as a factor."""
    return "not measured" if over(a, b) is None else number(a / b) + " ×"


def bar(value, least=None, most=None, unit=""):
    """What has to be reached, and whether it was."""
    if value is None:
        return ""
    met = value >= least if least is not None else value <= most
    text = f"at least {least:,g}" if least is not None else f"at most {most:,g}"
    return f"{text}{unit}: {'met' if met else '**missed**'}"


def table(header, rows):
    """A table in Markdown; columns after the first are numbers."""
    if not rows:
        return ""
    lines = ["| " + " | ".join(header) + " |", "|---|" + "---:|" * (len(header) - 1)]
    return "\n".join(lines + ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows]) + "\n"
