"""The floating rings of a draft tied to their surroundings, flush or by bars recessed in pinched slots."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from perfqr_cad.pattern.bridge import Bridge
from perfqr_cad.pattern.draft import Bar, Draft, Rect
from perfqr_cad.pattern.finder import Ring, RingBar, core_bar, is_traced, ring_bars, rings
from perfqr_cad.pattern.lattice import Cells
from perfqr_cad.pattern.spec import FinderStrategy, PatternSpec
from perfqr_cad.symbol import Symbol

# Modules of void that the outer bank leaves of the slot of a recessed bar: 0.32 to 0.40 do alike in modules
# of 1.3 mm. In modules of 2.4 mm a slot of 0.2 helps at a tilt, but costs frontal reads.
SLOT = 0.38


class _Slot(NamedTuple):
    """A pinched slot: what its outer bank gains, and the bar from there to the inner bank."""

    bank: Rect
    bar: Bar


def tie_rings(draft: Draft, symbol: Symbol, spec: PatternSpec) -> Draft:
    """The rings of finder and alignment patterns tied to their surroundings by the chosen strategy.

    Where the art leaves no straight banks for a recessed bar, the ring gets a flush one.
    """
    slots: list[_Slot] = []
    flush: list[RingBar] = []
    for ring in rings(symbol.version):
        if spec.finder == "recessed" and is_traced(ring, symbol.version):
            found = [_slot(draft, bar, spec) for bar in _bars(draft, ring, spec, "recessed")]
            if slot := next(iter(found), None):
                slots.append(slot)
                continue
        flush += _bars(draft, ring, spec, "panel" if spec.finder == "recessed" else spec.finder)
    draft = draft.with_solid([slot.bank for slot in slots])
    draft = draft.with_bars([[slot.bar] for slot in slots], "function", spec.bar_height_mm)
    return _with_flush(draft, flush, spec)


def settled(draft: Draft) -> Draft:
    """The draft with those recessed bars made flush that later work has joined to more than their banks."""
    return replace(
        draft,
        bridges=tuple(
            replace(bridge, height_mm=None) if bridge.is_recessed and not _is_free(draft, bridge) else bridge
            for bridge in draft.bridges
        ),
    )


def front_cells(draft: Draft) -> Cells:
    """`draft.upright` without the recessed bars: the material at the front face."""
    cells = draft.upright.copy()
    for bridge in draft.recessed:
        draft.rect(bridge).of(cells)[:] = False
    return cells


def _bars(draft: Draft, ring: Ring, spec: PatternSpec, strategy: FinderStrategy) -> list[RingBar]:
    lattice = draft.lattice
    u, edge = lattice.per_module, lattice.quiet * lattice.per_module
    width = 2 * lattice.whole(spec.web_mm / 2) / u
    if spec.tone == "inverted":
        return [core_bar(ring, strategy, width)]

    def solid(row: int, column: int) -> bool:
        """Whether the middle of a module is material."""
        x, y = (edge + (k * u) + u // 2 for k in (column, row))
        return 0 <= x < lattice.cells and 0 <= y < lattice.cells and bool(lattice.solid[y, x])

    return ring_bars(ring, strategy, width, solid)


def _with_flush(draft: Draft, chosen: list[RingBar], spec: PatternSpec) -> Draft:
    lattice = draft.lattice
    half = lattice.whole(spec.web_mm / 2)
    upright: list[Bar] = []
    for bar in chosen:
        (x0, y0), (x1, y1) = (_cell(draft, point) for point in (bar.start, bar.end))
        if x0 != x1 and y0 != y1:
            ends = lattice.to_mm(x0, y0), lattice.to_mm(x1, y1)
            draft = draft.with_slanted(Bridge(*ends, spec.web_mm, "function", 0.0))
        elif x0 == x1:
            upright.append(Bar(Rect(x0 - half, min(y0, y1), x0 + half, max(y0, y1)), along_x=False))
        else:
            upright.append(Bar(Rect(min(x0, x1), y0 - half, max(x0, x1), y0 + half), along_x=True))
    return draft.with_bars([[bar] for bar in upright], "function")


def _slot(draft: Draft, bar: RingBar, spec: PatternSpec) -> _Slot | None:
    """The slot that a recessed bar asks for; None where its banks are not straight or it is not void."""
    lattice = draft.lattice
    u = lattice.per_module
    half, gap = lattice.whole(spec.web_mm / 2), lattice.whole(spec.gap_mm)
    depth = max(0, u - max(gap, round(SLOT * u)))
    assert bar.pinch is not None
    first, last = (_cell(draft, (k, k))[0] for k in bar.pinch)
    start, end = _cell(draft, bar.start), _cell(draft, bar.end)
    along_x = start[1] == end[1]
    middle = start[1] if along_x else start[0]
    outer, inner = (start[0], end[0]) if along_x else (start[1], end[1])
    inwards = 1 if outer < inner else -1

    def rect(across: tuple[int, int], along: tuple[int, int]) -> Rect:
        """Cells between two lines across the ring, and two along it."""
        (x0, x1), (y0, y1) = (sorted(across), along) if along_x else (along, sorted(across))
        return Rect(x0, y0, x1, y1)

    beside, pinch = (middle - half - 1, middle + half + 1), (first, last)
    banks = rect((outer - inwards, outer), pinch), rect((inner, inner + inwards), beside)
    straight = all(bank.of(draft.solid).all() for bank in banks)
    if not straight or rect((outer, inner), pinch).of(draft.solid).any():
        return None
    tip = outer + inwards * depth
    return _Slot(rect((outer, tip), pinch), Bar(rect((tip, inner), (middle - half, middle + half)), along_x))


def _is_free(draft: Draft, bridge: Bridge) -> bool:
    """Whether a bar has void along both sides, and straight material across both ends and a cell more."""
    x0, y0, x1, y1 = draft.rect(bridge)
    along_x = bridge.start[1] == bridge.end[1]
    window = Rect(x0 - 1, y0 - 1, x1 + 1, y1 + 1).of(draft.solid)
    across = window.T if along_x else window
    sides = across[1:-1, [0, -1]]
    return bool(across[0].all() and across[-1].all() and not sides.any())


def _cell(draft: Draft, point: tuple[float, float]) -> tuple[int, int]:
    """The lattice point of a point in modules of the symbol."""
    u, edge = draft.lattice.per_module, draft.lattice.quiet * draft.lattice.per_module
    return round(edge + point[0] * u), round(edge + point[1] * u)
