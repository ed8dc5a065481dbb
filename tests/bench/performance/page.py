# SPDX-License-Identifier: GPL-3.0-or-later
"""The page: what it was measured on, what the numbers mean, and a section for each part that was measured."""
import detect_section
import growth_section
import roofline_section
import sections
from measured import number, table
from summary_section import summary

INTRODUCTION = """# Performance

How fast bouncelab is, beside what one would use otherwise, and how far from what the machine can do. `tools/bench` wrote this page in one run; it is not edited by hand.

- **Ratios before seconds.** Each figure stands beside a named baseline that ran in the same run, mostly in turn with it. Another machine, or other work on it, changes seconds a lot and ratios little.
- **Processor time** is user and system time of all threads of a command (or of one thread, inside a program): the least of several runs. **Wall** is time on the clock. Both are in seconds unless stated.
- **Times real time**: length of the sound over the time taken; larger is faster.
- **Bars** are the project's own aims for two cores. *met* and *missed* are what this run found; no test asserts a time.
- Words are those of the [glossary](glossary.md): a *drop* is a flight from rest and a series of impacts, an *asperity* a small sphere on the ball's surface, an *onset* a detected impact.
"""

SECTIONS = (("loop", sections.loop), ("detect", detect_section.detect), ("synthesize", sections.synthesize), ("simulate", sections.simulate),
            ("fit", sections.fit), ("start-up", sections.start_up), ("machine", roofline_section.roofline), ("growth", growth_section.growth))


def facts(measured):
    rows = [(what, measured.get("run", "machine", what)) for what in measured.names("run", "machine")]
    minutes = (measured.get("run", "", "seconds") or 0) / 60
    return "## The machine\n\n" + table(("", ""), rows + [("the whole run", number(minutes) + " min")]).replace("---:|", "---|")


def page_of(measured):
    parts = [section(measured) for name, section in SECTIONS if measured.has(name)]
    numbered = [part.replace("## ", f"## {k + 1}. ", 1) for k, part in enumerate(parts)]
    return "\n".join([part for part in (INTRODUCTION, summary(measured), facts(measured), *numbered) if part])
