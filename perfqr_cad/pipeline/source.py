"""The symbol of a request: of its text, drawn so that it hangs together, or of the code in a picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from perfqr_cad.errors import DesignError
from perfqr_cad.pipeline.request import Request
from perfqr_cad.pipeline.resolve import Terms

NONE = "none"  # of the freedoms


if TYPE_CHECKING:
    from perfqr_cad.capture import Capture
    from perfqr_cad.pattern.choice import Chosen
    from perfqr_cad.symbol import Level, Symbol


@dataclass(frozen=True, eq=False)
class Source:
    """The symbol, and where it comes from: a picture, or the choice among the drawings of a text."""

    symbol: Symbol
    capture: Capture | None = None
    choice: Chosen | None = None


def source(request: Request, terms: Terms) -> Source:
    """The symbol of a picture with its codewords corrected, or of a text as it needs the least joining."""
    if request.image is not None:
        from perfqr_cad.capture import read

        capture = read(request.image, request.which)
        return Source(capture.recovery.symbol, capture=capture)
    from perfqr_cad.pattern.choice import chosen

    assert request.text is not None  # Request holds exactly one of text and image
    level: Level = request.level  # pyright: ignore[reportAssignmentType]  # `encode` refuses other letters
    choice = chosen(
        request.text,
        terms.drawing,
        level=level,
        version=request.version,
        mask=request.mask,
        free=freedoms(request),
    )
    return Source(choice.symbol, choice=choice)


def freedoms(request: Request) -> frozenset[str]:
    """What of the code may be chosen, by name."""
    from perfqr_cad.pattern.choice import FREEDOMS

    named = frozenset(name.strip() for name in request.freedom.split(",") if name.strip())
    if unknown := sorted(named - {*FREEDOMS, NONE}):
        raise DesignError(f"freedom {unknown[0]!r} is unknown: use {NONE}, or some of {','.join(FREEDOMS)}")
    return named
