"""Which drawing of a message needs the least joining: of masks, of bits that pad it, of two versions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from perfqr_cad.pattern.arrangement import Joining, arranged, joining
from perfqr_cad.pattern.drawing.size import can_be_made
from perfqr_cad.pattern.spec import PatternSpec
from perfqr_cad.symbol import Symbol, freedom, padded, size_of
from perfqr_cad.symbol.tables import MAX_VERSION

FREEDOMS = ("mask", "segment", "pad", "version")
MASKS = tuple(range(8))
MASKS_PURSUED = 2  # of those that come out best at first; of large symbols one
# Modules that may be looked at in the rounds of one mask: 60 at version 3, the least at version 40.
MOST_MODULES = 60_000
LEAST_ROUNDS, MOST_ROUNDS = 3, 60
# Smaller modules read less well from aside: the next version must be worth it.
LEAST_OF_MODULE = (
    0.87  # of the smallest version's module edge; with a quiet zone of 4 the next one always keeps this
)
WORTH_IT = 0.85  # of the smallest version's joining: what the next one may still need


@dataclass(frozen=True, eq=False)
class Chosen:
    """The symbol that was chosen, the one that an encoder without these freedoms draws, and what each of the
    two leaves to be joined."""

    symbol: Symbol
    plain: Symbol
    left: Joining
    left_plain: Joining

    @property
    def pads_are_free(self) -> bool:
        """Whether bits after the terminator differ from the 0xEC, 0x11, … of ISO/IEC 18004 §7.4.10."""
        return self.symbol.data != padded(self.symbol).data


def chosen(
    write: Callable[..., Symbol],
    spec: PatternSpec,
    *,
    version: int | None = None,
    mask: int | None = None,
    free: frozenset[str] = frozenset(FREEDOMS),
) -> Chosen:
    """The drawing of a text that needs the least joining, within the freedoms named in `free`.

    write    `encode` with the text, its level and all but version, mask and mode given

    mask     masks other than the one with the least penalty
    segment  the text cut into segments of different modes
    pad      bits after the terminator other than the standard's
    version  the next larger version, where the size is given and its modules are worth it
    A version or mask that is given stays. SymbolError as from `encode`.

    >>> from functools import partial
    >>> from perfqr_cad.symbol import encode
    >>> chosen(partial(encode, "HELLO", level="L"), PatternSpec(size_mm=60), mask=2).symbol.mask
    2
    """
    plain = write(version=version, mask=mask)
    cut = write(version=version, mask=mask, mode="mixed") if "segment" in free else plain
    masks = MASKS if mask is None and "mask" in free else (cut.mask,)
    best, left = easiest(cut, spec, masks=masks, pads="pad" in free)
    if "version" in free and version is None and _may_grow(cut, spec):
        mode = "mixed" if "segment" in free else None
        larger = write(version=cut.version + 1, mask=cut.mask, mode=mode)
        if can_be_made(larger, spec):
            other, left_there = easiest(larger, spec, masks=masks, pads="pad" in free)
            if left_there.area <= WORTH_IT * left.area:
                best, left = other, left_there
    return Chosen(best, plain, left, joining(plain, spec.tone == "inverted", spec.quiet_modules))


def _may_grow(symbol: Symbol, spec: PatternSpec) -> bool:
    """Whether there is a next version, and its modules are not much smaller in the size that is given."""
    if spec.size_mm is None or symbol.version == MAX_VERSION:
        return False
    quiet = 2 * spec.quiet_modules
    return (symbol.size + quiet) / (size_of(symbol.version + 1) + quiet) >= LEAST_OF_MODULE


def easiest(
    symbol: Symbol, spec: PatternSpec, *, masks: Sequence[int] = MASKS, pads: bool = True
) -> tuple[Symbol, Joining]:
    """The same message as its material hangs together best, and what is left to be joined: under one of these
    masks, and, with `pads`, with other bits after the terminator.

    All of them are valid to every reader. Estimated is the area that links at corners and routes between
    islands would paint; of equal ones the first.

    >>> from perfqr_cad.symbol import encode, payload_of
    >>> symbol, left = easiest(encode("HELLO", version=2), PatternSpec())
    >>> payload_of(symbol).text
    'HELLO'
    """
    solid_is_dark = spec.tone == "inverted"
    spaces = [freedom(replace(symbol, mask=mask)) for mask in masks]
    if not pads or not spaces[0].dimension:
        drawings = [
            (space.symbol, joining(space.symbol, solid_is_dark, spec.quiet_modules)) for space in spaces
        ]
        return min(drawings, key=lambda one: one[1].area)
    affordable = MOST_MODULES // symbol.size**2
    rounds = min(max(affordable, LEAST_ROUNDS), MOST_ROUNDS)
    spaces.sort(key=lambda space: joining(space.symbol, solid_is_dark, spec.quiet_modules).area)
    spaces = spaces[: max(2 * affordable, LEAST_ROUNDS)]
    found: list[tuple[Symbol, Joining]] = []
    for count in (1, rounds):
        now = [arranged(space, solid_is_dark, spec.quiet_modules, count, spec.seed) for space in spaces]
        found += now
        order = sorted(range(len(spaces)), key=lambda k: now[k][1].area)
        spaces = [spaces[k] for k in order[: MASKS_PURSUED if affordable > LEAST_ROUNDS else 1]]
    return min(found, key=lambda one: one[1].area)
