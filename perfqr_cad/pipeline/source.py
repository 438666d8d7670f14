"""The symbol of a request: of its text, drawn so that it hangs together, or of the code in a picture."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from perfqr_cad import content
from perfqr_cad.bounded import read_bytes
from perfqr_cad.errors import DesignError
from perfqr_cad.pipeline.request import Request
from perfqr_cad.pipeline.resolve import Terms

NONE = "none"  # of the freedoms
CASE = "case"  # changes letters of the text, so it is one on request alone
MOST_BYTES = 2953  # of a payload: version 40-L, ISO/IEC 18004 Table 7


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
    from perfqr_cad.symbol import encode

    data, fnc1 = message(request)
    free = freedoms(request)
    if CASE in free and isinstance(data, str):
        data = in_capitals(data)
    level: Level = request.level  # pyright: ignore[reportAssignmentType]  # `encode` refuses other letters
    write = partial(encode, data, level=level, eci=not request.no_eci, fnc1=fnc1)
    choice = chosen(write, terms.drawing, version=request.version, mask=request.mask, free=free)
    return Source(choice.symbol, choice=choice)


def message(request: Request) -> tuple[str | bytes, bool]:
    """What the code is to say, and whether it is marked by FNC1 as GS1 data.

    Raises `DesignError` for parts that cannot be meant.
    """
    if request.text is not None:
        return request.text, False
    if request.bytes is not None:
        return read_bytes(request.bytes, MOST_BYTES, DesignError, "a file whose bytes a code can hold"), False
    kind, given = next(
        (kind, given) for kind in content.CONTENTS if (given := getattr(request, kind)) is not None
    )
    if kind == "gs1" and request.gs1_link is not None:
        return content.link(given, request.gs1_link), False
    return content.message(kind, given), kind == "gs1"


def freedoms(request: Request) -> frozenset[str]:
    """What of the code may be chosen, by name."""
    from perfqr_cad.pattern.choice import FREEDOMS

    known = (*FREEDOMS, CASE)
    named = frozenset(name.strip() for name in request.freedom.split(",") if name.strip())
    if unknown := sorted(named - {*known, NONE}):
        raise DesignError(f"freedom {unknown[0]!r} is unknown: use {NONE}, or some of {','.join(known)}")
    return named


def in_capitals(text: str) -> str:
    """An address with its scheme and host in capitals, which mean the same (RFC 3986 §6.2.2.1) and take 5.5
    bits a letter instead of 8; other texts as they are.

    >>> in_capitals("https://example.com/p/1"), in_capitals("see https://example.com")
    ('HTTPS://EXAMPLE.COM/p/1', 'see https://example.com')
    """
    address = re.match(r"[a-z][a-z0-9+.-]*://[a-z0-9.:-]+(?=[/?#]|$)", text, re.IGNORECASE)
    return text if address is None else address[0].upper() + text[address.end() :]
