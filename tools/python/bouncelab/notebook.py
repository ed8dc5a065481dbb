# SPDX-License-Identifier: GPL-3.0-or-later
"""How results look in a notebook."""
from __future__ import annotations

import base64
import html
import io
from typing import Any, Callable

_MOST_ROWS = 10


def _picture(draw: Callable[[Any], None]) -> str:
    """A picture as an <img>; empty where Matplotlib is not installed."""
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError:
        return ""
    figure = Figure(figsize=(6.4, 3.2), layout="constrained")
    FigureCanvasAgg(figure)
    draw(figure.subplots())
    png = io.BytesIO()
    figure.savefig(png, dpi=110)
    return f'<img alt="" src="data:image/png;base64,{base64.b64encode(png.getvalue()).decode()}">'


def table_html(table: Any) -> str:
    """The first rows of a table."""
    names = list(table)
    head = "".join(f"<th>{html.escape(name)}</th>" for name in names)
    rows = ""
    for k in range(min(len(table), _MOST_ROWS)):
        cells = (table[name][k] for name in names)
        rows += "<tr>" + "".join(
            f"<td>{html.escape(f'{c:.6g}' if isinstance(c, float) else str(c))}</td>" for c in cells) + "</tr>"
    more = f"<p>... of {len(table)} rows</p>" if len(table) > _MOST_ROWS else ""
    return f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>{more}"


def recording_html(recording: Any) -> str:
    from .plot import sound

    return f"<p>{html.escape(repr(recording)[1:-1])}</p>" + _picture(
        lambda ax: sound(recording.samples, recording.rate, recording.truth, ax=ax))


def fit_html(fit: Any) -> str:
    """The answer in words and the curve."""
    words = html.escape(fit.answer or fit._why())
    first, *others = words.split("\n")
    text = f"<p><b>{first}</b></p>" + "".join(f"<p>{line}</p>" for line in others)
    if not fit.results["curve"]:
        return text
    from .plot import restitution

    return text + _picture(lambda ax: restitution(fit, ax=ax))
