"""Pieces of the report as plain HTML and SVG: tables, embedded pictures, a line chart, a heat map."""

from __future__ import annotations

import base64
import math
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

# Suffix of a key -> unit that people read.
UNITS = {
    "_mm": "mm", "_mm2": "mm²", "_mm3": "mm³", "_mpa": "MPa", "_n": "N", "_g": "g", "_deg": "°", "_s": "s",
}  # fmt: skip
CHART_WIDTH, CHART_HEIGHT, MARGIN = 520, 220, 46  # SVG units


def facts(section: Mapping[str, Any]) -> str:
    """The single values of a certificate's section as a table; null reads "not measured"."""
    rows = ((key_text(key), cell(key, value)) for key, value in section.items() if _single(value))
    return table((), rows)


def key_text(key: str) -> str:
    """A key as people read it: no underscores, no unit."""
    unit = _unit(key)
    return (key.removesuffix(unit) if unit else key).replace("_", " ")


def cell(key: str, value: Any) -> str:
    """A value with the unit that its key names."""
    if isinstance(value, list | tuple):
        return " × ".join(cell("", item) for item in value) + _spaced(key)
    if value is None:
        return "not measured"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return (f"{value:.4g}" if math.isfinite(value) else "∞") + _spaced(key)
    return f"{value}{_spaced(key)}" if isinstance(value, int) else str(value)


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of plain text; the first cell of each row is its header."""
    top = f"<thead><tr>{''.join(f'<th>{escape(h)}</th>' for h in head)}</tr></thead>" if head else ""
    body = "".join(
        f"<tr><th>{escape(first)}</th>{''.join(f'<td>{escape(value)}</td>' for value in rest)}</tr>\n"
        for first, *rest in rows
    )
    return f"<table>{top}<tbody>\n{body}</tbody></table>"


def heat_map(columns: Sequence[str], rows: Iterable[tuple[str, Sequence[float], str]]) -> str:
    """Rates 0 to 1 as coloured cells: rows of (name, one rate a column, remark)."""
    head = "".join(f"<th>{escape(column)}</th>" for column in columns)
    body = "".join(
        f"<tr><th>{escape(name)}</th>{''.join(_heat(rate) for rate in rates)}<td>{escape(remark)}</td></tr>\n"
        for name, rates, remark in rows
    )
    return (
        f'<table class="heat"><thead><tr><th></th>{head}<th></th></tr></thead><tbody>\n{body}</tbody></table>'
    )


def figure(content: str, caption: str) -> str:
    """Any content over a caption."""
    return f"<figure>{content}<figcaption>{escape(caption)}</figcaption></figure>"


def image(picture: NDArray[np.uint8], text: str) -> str:
    """A grey (h, w) or RGB (h, w, 3) picture inside the page."""
    import cv2

    _, data = cv2.imencode(".png", picture if picture.ndim == 2 else picture[..., ::-1])
    return png_image(data.tobytes(), text)


def png_image(data: bytes, text: str) -> str:
    """The bytes of a PNG inside the page."""
    return f'<img alt="{escape(text)}" src="data:image/png;base64,{base64.b64encode(data).decode("ascii")}">'


def line_chart(values: Sequence[float], *, x_label: str, y_label: str, limit: float | None = None) -> str:
    """Values over 0, 1, 2, ... as SVG; `limit` is drawn as a dashed line."""
    finite = [v for v in (*values, *([] if limit is None else [limit])) if math.isfinite(v)]
    top = _nice_ceiling(max(finite, default=1.0))
    x_end = max(len(values) - 1, 1)

    def at(x: float, y: float) -> str:
        across = MARGIN + x / x_end * (CHART_WIDTH - MARGIN - 12)
        return f"{across:.1f},{CHART_HEIGHT - MARGIN + 8 - y / top * (CHART_HEIGHT - MARGIN - 12):.1f}"

    steps = [at(x, y) for x, y in enumerate(values) if math.isfinite(y)]
    parts = [
        f'<polyline class="axis" points="{at(0, top)} {at(0, 0)} {at(x_end, 0)}"/>',
        *(_text(at(0, y), f"{y:.3g}", -6, 4, "end") for y in (0.0, top / 2, top)),
        *(_text(at(x, 0), f"{x:g}", 0, 16, "middle") for x in sorted({0, x_end // 2, x_end})),
        _text(at(x_end / 2, 0), x_label, 0, 33, "middle"),
        f'<text transform="translate(11,{CHART_HEIGHT / 2 - 12}) rotate(-90)" text-anchor="middle">'
        f"{escape(y_label)}</text>",
        f'<polyline class="line" points="{" ".join(steps)}"/>',
    ]
    if limit is not None:
        parts.insert(1, f'<polyline class="limit" points="{at(0, limit)} {at(x_end, limit)}"/>')
    return f'<svg class="chart" viewBox="0 0 {CHART_WIDTH} {CHART_HEIGHT}">\n' + "\n".join(parts) + "\n</svg>"


def _text(at: str, text: str, dx: int, dy: int, anchor: str) -> str:
    x, y = at.split(",")
    return f'<text x="{x}" y="{y}" dx="{dx}" dy="{dy}" text-anchor="{anchor}">{escape(text)}</text>'


def _nice_ceiling(value: float) -> float:
    """The least of 1, 2, 5 times a power of ten that is not below the value."""
    if value <= 0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in (1, 2, 5, 10) if step * power >= value * (1 - 1e-9))


def _heat(rate: float) -> str:
    red, green, blue = (round(a + (b - a) * rate) for a, b in zip((214, 69, 65), (63, 157, 92), strict=True))
    return f'<td style="background:rgb({red},{green},{blue})">{rate:.0%}</td>'


def _single(value: Any) -> bool:
    """Whether a value fits one cell: a scalar or a short list of numbers."""
    if isinstance(value, list | tuple):
        return 0 < len(value) <= 3 and all(isinstance(item, int | float) for item in value)
    return not isinstance(value, Mapping)


def _unit(key: str) -> str:
    return next((suffix for suffix in sorted(UNITS, key=len, reverse=True) if key.endswith(suffix)), "")


def _spaced(key: str) -> str:
    unit = UNITS.get(_unit(key), "")
    return unit if unit == "°" else f" {unit}" if unit else ""
