"""Several codes in one picture: whether two are the same, how they are numbered, and which is meant."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TypeVar

import cv2
import numpy as np

from perfqr_cad.capture.grid import Floats, convex_area
from perfqr_cad.errors import CaptureError
from perfqr_cad.remedy import Remedy, option
from perfqr_cad.symbol import Payload

SAME_AREA = 0.1  # of the smaller outline: two codes lie apart by their quiet zones, two views of one coincide
LISTED_CODES = 12  # in a message of one line
LISTED_LETTERS = 40  # of each payload there

Code = TypeVar("Code")


def overlap(one: Floats, other: Floats) -> bool:
    """Whether two outlines (4, 2) share so much that they are of one code; outlines without area do not."""
    least = min(convex_area(one), convex_area(other))
    if least <= 0:
        return False
    shared, _ = cv2.intersectConvexConvex(one.astype(np.float32), other.astype(np.float32))
    return shared > SAME_AREA * least


def in_reading_order(codes: Iterable[Code], outline: Callable[[Code], Floats]) -> list[Code]:
    """Codes by rows from the top, each from the left; a row is what begins above the middle of its first.

    >>> square = np.array([[0, 0], [10, 0], [10, 10], [0, 10]])
    >>> places = {"right": (20, 0), "below": (0, 20), "left": (0, 4)}
    >>> in_reading_order(places, lambda name: square + np.array(places[name]))
    ['left', 'right', 'below']
    """
    rows: list[tuple[float, list[Code]]] = []
    for code in sorted(codes, key=lambda one: float(outline(one)[:, 1].min())):
        top, bottom = outline(code)[:, 1].min(), outline(code)[:, 1].max()
        if not rows or top > rows[-1][0]:
            rows.append((float(top + bottom) / 2, []))
        rows[-1][1].append(code)
    return [one for _, row in rows for one in sorted(row, key=lambda code: float(outline(code)[:, 0].mean()))]


def choice(payloads: Sequence[Payload], which: int | None, name: str) -> int:
    """The number, from 1, of the code that is meant. CaptureError lists them where that is not plain."""
    count = len(payloads)
    if which is None and count == 1:
        return 1
    if which is not None and 1 <= which <= count:
        return which
    shown = [f"{number} {_named(one)}" for number, one in enumerate(payloads[:LISTED_CODES], start=1)]
    more = [f"and {count - LISTED_CODES} more"] if count > LISTED_CODES else []
    held = f"{name} holds {count} QR code{'s' if count > 1 else ''}: {', '.join(shown + more)}"
    missing = "" if which is None else f"there is no number {which}"
    if count == 1:
        raise CaptureError(f"{held}; {missing}", Remedy(which=None))
    choose = f"choose one with {option('which')} N, 1 to {count}"
    raise CaptureError(f"{held}; {': '.join(filter(None, [missing, choose]))}")


def shortened(text: str) -> str:
    """The beginning of a text in quotes, on one line."""
    return repr(text if len(text) <= LISTED_LETTERS else f"{text[: LISTED_LETTERS - 1]}…")


def _named(payload: Payload) -> str:
    return f"{len(payload.data)} bytes" if payload.text is None else shortened(payload.text)
