"""What the chain promises of every part, checked once more at its end on the finished values alone."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from perfqr_cad.errors import DesignError, SymbolError

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern
    from perfqr_cad.solid import Solid
    from perfqr_cad.symbol import Readability

VOLUME_TOL = 1e-6  # share by which the solid may differ from its outline's own volume, as on curved walls


@dataclass(frozen=True)
class Promise:
    """One check of the finished part: what it measures, the figure, its limit, and whether that is kept."""

    name: str
    value: float | str | None
    limit: str
    kept: bool

    def as_dict(self) -> dict[str, Any]:
        """The promise as the certificate lists it."""
        return asdict(self)


def promises(pattern: Pattern, solid: Solid) -> tuple[Promise, ...]:
    """Every promise of a part, kept or not; none is left out."""
    return (
        *of_code(pattern),
        _pieces(pattern),
        _bodies(solid),
        _watertight(solid),
        _boundary(solid),
        _volume(solid),
    )


def of_code(pattern: Pattern) -> tuple[Promise, ...]:
    """The promises that the drawing alone keeps or not: they are asked for before the long steps, too."""
    from perfqr_cad.symbol import readability

    seen = readability(pattern.observed, pattern.symbol)  # anew, from what was sampled on the finished region
    return (_readability(seen), *_blocks(seen), _payload(pattern))


def require_kept(made: Iterable[Promise]) -> None:
    """Raises `DesignError` for promises that are not kept, with their figures and limits."""
    broken = [f"{one.name} is {one.value}, must be {one.limit}" for one in made if not one.kept]
    if broken:
        raise DesignError(
            f"the part fails its own checks: {'; '.join(broken)}",
            "another size",
            "the text itself instead of a picture",
        )


def _readability(seen: Readability) -> Promise:
    """L(Q) of Eqs. (1)-(3)."""
    loss = seen.total
    return Promise("readability", loss if math.isfinite(loss) else "infinite", "finite", math.isfinite(loss))


def _blocks(seen: Readability) -> Iterable[Promise]:
    """Errors of each block against what it can correct."""
    pairs = zip(seen.errors, seen.capacity, strict=True)
    for number, (errors, capacity) in enumerate(pairs, start=1):
        yield Promise(f"block {number}", errors, f"at most {capacity} wrong codewords", errors <= capacity)


def _payload(pattern: Pattern) -> Promise:
    """What our own reader makes of the matrix that was sampled on the finished region."""
    from perfqr_cad.symbol import payload_of, recover

    wanted = payload_of(pattern.symbol).data
    try:
        found = recover(pattern.observed).payload.data
    except SymbolError as error:
        return Promise("payload", str(error), "read back", False)
    return Promise("payload", f"{len(found)} bytes", "read back to the byte", found == wanted)


def _pieces(pattern: Pattern) -> Promise:
    """Pieces of the region once half the least web is taken off all around."""
    from perfqr_cad.pattern.drawing.contours import web_pieces

    web_mm = pattern.spec.web_mm
    count = len(web_pieces(pattern.web_polygon, web_mm))
    return Promise("web", count, f"1 piece with {web_mm / 2:g} mm off all around", count == 1)


def _bodies(solid: Solid) -> Promise:
    count = solid.triangles.body_count
    return Promise("pieces", count, "1", count == 1)


def _watertight(solid: Solid) -> Promise:
    closed = solid.triangles.closed
    return Promise("watertight", "closed" if closed else "open", "closed", closed)


def _boundary(solid: Solid) -> Promise:
    return Promise("boundary", "; ".join(solid.problems) or "sound", "sound", solid.valid)


def _volume(solid: Solid) -> Promise:
    """The solid's volume against that of outline and surface; carved hosts have no such figure."""
    expected = solid.expected_volume_mm3
    if expected is None:
        return Promise("volume", solid.volume_mm3, "above 0 mm³", solid.volume_mm3 > 0)
    share = abs(solid.volume_mm3 - expected) / expected
    return Promise("volume", share, f"within {VOLUME_TOL:g} of {expected:.9g} mm³", share <= VOLUME_TOL)
