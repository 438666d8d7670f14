"""The floating rings of a canvas tied to their surroundings, flush or by bars recessed in pinched slots."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from perfqr_cad.pattern.bridge import Bridge
from perfqr_cad.pattern.cells.canvas import Bar, Canvas, Rect
from perfqr_cad.pattern.cells.lattice import Cells
from perfqr_cad.pattern.joining.finder import (
    CLEAR,
    FLUSH,
    Ring,
    RingBar,
    Solid,
    core_bar,
    dark_pair,
    is_located,
    is_traced,
    opposite_bars,
    paired_bars,
    recessed_bars,
    recessed_core_bar,
    ring_bars,
    rings,
)
from perfqr_cad.pattern.spec import ON_TWO_SIDES, PAIR, PatternSpec
from perfqr_cad.symbol import Symbol

# Modules of void that the outer bank leaves of the pinched slot, no less than the least gap. A narrower one
# makes its bar darker seen from near above, a wider one shows more of the ring from the side and in a blurred
# picture. Version 5, modules of 1.33 mm, walls of 1.6 mm flared by 15°, 24 views a cell, zxing-cpp at
# 10/20/30/40°: 79/83/92/58 % with 0.5, 92/96/96/62 % with 0.42, 100/100/88/62 % with 0.33; at 5/20/30° with a
# blur of half a module 100/100/96 % with 0.42, 100/92/67 % with 0.33.
SLOT = 0.42
# How dark a bar lies goes by the slot's width over its depth, and that does not grow with the modules. Of
# 2 mm 92/100/100/96 % with 0.34 (0.7 mm), 100/100/96/79 % with 0.25; of 3 mm 50 % at 20° with 0.42 (1.3 mm),
# 83 % with 0.34, 100 % with 0.25 (0.75 mm). Less than a quarter of a module is not seen: 50 % with 0.17.
DARK_MM = 0.6
LEAST_SLOT_MODULES = 0.25
# Modules that a bar on a finder is wide. In the shade of a slot a wide bar is as dark as a narrow one, and an
# upper ring may be broken once anyhow; beyond three of seven modules from the corner a pinch meets the
# 1:1:3:1:1 line. In modules over 1.6 mm a wide bar is seen as wide, and 2.4 mm are enough. docs/pattern.md.
WIDE = 1.5
WIDE_MM = 2.4
ALIGNMENT = (1.5, 1.2)  # modules that a bar on an alignment pattern is wide, where banks allow
# From here on zxing-cpp looks for all alignment patterns; before, lines along the finders do as well as the
# one that there is (QRDetector.cpp), and a flush bar on it costs nothing: 20 views a cell, all the same.
TILED = 7


class _Slot(NamedTuple):
    """A recessed bar from bank to bank of its slot, and what the outer bank gains by a pinch."""

    bar: Bar
    bank: Rect | None


def tie_rings(canvas: Canvas, symbol: Symbol, spec: PatternSpec) -> Canvas:
    """The rings of finder and alignment patterns tied to their surroundings by the chosen strategy.

    Where the art leaves no straight banks for a recessed bar, the ring gets a flush one.
    """
    slots: list[_Slot] = []
    flush: list[RingBar] = []
    for ring in rings(symbol.version):
        found = _recess(canvas, ring, symbol.version, spec) if spec.finder == "recessed" else ()
        slots += found
        flush += [] if found else _flush(canvas, ring, spec)
    canvas = canvas.with_solid([slot.bank for slot in slots if slot.bank is not None])
    for pinched in (False, True):
        bars = [[slot.bar] for slot in slots if (slot.bank is not None) == pinched]
        canvas = canvas.with_bars(bars, "function", height_mm=spec.bar_height_mm, pinched=pinched)
    return _with_flush(canvas, flush, spec)


def flush_where_joined(canvas: Canvas, spec: PatternSpec) -> Canvas:
    """The canvas with those recessed bars made flush that later work has joined to more than their banks."""
    taken = [bridge for bridge in canvas.recessed if not _is_free(canvas, bridge, spec)]
    if not taken:
        return canvas
    kept = tuple(
        replace(bridge, height_mm=None, pinched=False, width_mm=_web_mm(canvas, spec))
        if bridge in taken
        else bridge
        for bridge in canvas.bridges
    )
    canvas = canvas.with_solid([canvas.rect(_as_web(canvas, bridge, spec)) for bridge in taken])
    return replace(canvas, bridges=kept)


def as_webs(canvas: Canvas, spec: PatternSpec) -> tuple[Bridge, ...]:
    """The recessed bars, none narrower than the least web.

    The rule of the least web is held by all other material. Bars of pinched slots may be asked to be one
    nozzle line wide: they are no longer than the slot is wide, lie on the bed and have solid material at
    both ends.
    """
    return tuple(_as_web(canvas, bridge, spec) for bridge in canvas.recessed)


def _as_web(canvas: Canvas, bridge: Bridge, spec: PatternSpec) -> Bridge:
    return replace(bridge, width_mm=max(bridge.width_mm, _web_mm(canvas, spec)))


def _web_mm(canvas: Canvas, spec: PatternSpec) -> float:
    """The least web in whole cells on either side of a middle."""
    return 2 * canvas.lattice.whole(spec.web_mm / 2) * canvas.lattice.cell_mm


def front_cells(canvas: Canvas) -> Cells:
    """`canvas.upright` without the recessed bars: the material at the front face."""
    cells = canvas.upright.copy()
    for bridge in canvas.recessed:
        canvas.rect(bridge).of(cells)[:] = False
    return cells


def _recess(canvas: Canvas, ring: Ring, version: int, spec: PatternSpec) -> Sequence[_Slot]:
    """The slots of the bars behind the face that hold a ring; none where the banks do not allow them."""
    for bars in _recessed(canvas, ring, version, spec):
        slots = [slot for bar in bars if (slot := _slot(canvas, bar, spec)) is not None]
        if len(slots) == len(bars):
            return slots
    return ()


def _recessed(canvas: Canvas, ring: Ring, version: int, spec: PatternSpec) -> Iterator[list[RingBar]]:
    """Sets of bars behind the face that would hold a ring, the best first."""
    traced, located = is_traced(ring, version), is_located(ring)
    web = _modules(canvas, spec.web_mm)
    line = web if spec.bar_width_mm is None else _modules(canvas, spec.bar_width_mm)
    clear = max(CLEAR, canvas.lattice.whole(spec.gap_mm) / canvas.lattice.per_module)
    if spec.tone == "inverted":
        yield from [[recessed_core_bar(ring, line, clear)]] if traced else []
        return
    material = _material(canvas)
    wide = max(web, min(WIDE, _modules(canvas, WIDE_MM))) if spec.bar_width_mm is None else line
    if spec.bars == ON_TWO_SIDES:
        yield from _strong(canvas, ring, version, wide, spec)
        if located:
            return
    if spec.bars == PAIR and traced:  # in a pinched slot two bars are one: it is dark all along
        both = min(2 * wide, ring.size - 2 * (FLUSH + clear))
        yield from ([bar] for bar in recessed_bars(ring, both, clear, material, pinched=True))
    elif spec.bars > 1 and not (traced or located):
        yield from paired_bars(ring, max(wide, web), clear, material)
    if not located:
        yield from (
            [bar] for bar in recessed_bars(ring, wide if traced else max(wide, web), clear, material, traced)
        )
    if traced or located:
        yield from ([bar] for bar in recessed_bars(ring, line, clear, material, pinched=True))
    if not traced:
        yield from ([bar] for bar in recessed_bars(ring, max(line, web), clear, material, pinched=False))


def _strong(
    canvas: Canvas, ring: Ring, version: int, wide: float, spec: PatternSpec
) -> Iterator[list[RingBar]]:
    """Sets of bars that bear more than one bar does and are read as well, the best first."""
    web, material = _modules(canvas, spec.web_mm), _material(canvas)
    if is_located(ring):
        if version >= TILED:
            for width in (min(wide, broad) for broad in ALIGNMENT):
                yield from ([bar] for bar in recessed_bars(ring, width, CLEAR, material, pinched=True))
    else:
        slot = _slot_cells(canvas, spec) / canvas.lattice.per_module
        bars = dark_pair if is_traced(ring, version) else opposite_bars
        yield bars(ring, wide, web, slot)


def _flush(canvas: Canvas, ring: Ring, spec: PatternSpec) -> list[RingBar]:
    """Bars through the whole thickness that hold a ring."""
    width = _modules(canvas, spec.web_mm)
    if spec.tone == "inverted":
        return [core_bar(ring, width)]
    return ring_bars(ring, spec.finder, width, _material(canvas))


def _modules(canvas: Canvas, width_mm: float) -> float:
    """A width in modules, of whole cells on either side of a middle."""
    return 2 * canvas.lattice.whole(width_mm / 2) / canvas.lattice.per_module


def _material(canvas: Canvas) -> Solid:
    lattice = canvas.lattice
    u, edge = lattice.per_module, lattice.quiet * lattice.per_module

    def solid(row: int, column: int) -> bool:
        """Whether the middle of a module is material."""
        x, y = (edge + (k * u) + u // 2 for k in (column, row))
        return 0 <= x < lattice.cells and 0 <= y < lattice.cells and bool(lattice.solid[y, x])

    return solid


def _with_flush(canvas: Canvas, chosen: list[RingBar], spec: PatternSpec) -> Canvas:
    lattice = canvas.lattice
    half = lattice.whole(spec.web_mm / 2)
    upright: list[Bar] = []
    for bar in chosen:
        (x0, y0), (x1, y1) = (_cell(canvas, point) for point in (bar.start, bar.end))
        if x0 != x1 and y0 != y1:
            ends = lattice.to_mm(x0, y0), lattice.to_mm(x1, y1)
            canvas = canvas.with_slanted(Bridge(*ends, spec.web_mm, "function", 0.0))
        elif x0 == x1:
            upright.append(Bar(Rect(x0 - half, min(y0, y1), x0 + half, max(y0, y1)), along_x=False))
        else:
            upright.append(Bar(Rect(min(x0, x1), y0 - half, max(x0, x1), y0 + half), along_x=True))
    return canvas.with_bars([[bar] for bar in upright], "function")


def _slot(canvas: Canvas, bar: RingBar, spec: PatternSpec) -> _Slot | None:
    """The slot that a recessed bar asks for; None where its banks are not straight or it is not void."""
    lattice = canvas.lattice
    u = lattice.per_module
    half, gap = round(bar.width * u / 2), lattice.whole(spec.gap_mm)
    start, end = _cell(canvas, bar.start), _cell(canvas, bar.end)
    along_x = start[1] == end[1]
    middle = start[1] if along_x else start[0]
    outer, inner = (start[0], end[0]) if along_x else (start[1], end[1])
    inwards = 1 if outer < inner else -1
    beside = middle - half - gap, middle + half + gap
    slot, tip = beside, outer
    if bar.pinch is not None:
        first, last = (_cell(canvas, (k, k))[0] for k in bar.pinch)
        slot = first, last
        tip = outer + inwards * max(0, u - _slot_cells(canvas, spec))

    def rect(across: tuple[int, int], along: tuple[int, int]) -> Rect:
        """Cells between two lines across the ring, and two along it."""
        (x0, x1), (y0, y1) = (sorted(across), along) if along_x else (along, sorted(across))
        return Rect(x0, y0, x1, y1)

    banks = rect((outer - inwards, outer), slot), rect((inner, inner + inwards), beside)
    straight = all(bank.of(canvas.solid).all() for bank in banks)
    if not straight or rect((outer, inner), slot).of(canvas.solid).any():
        return None
    bank = rect((outer, tip), slot) if tip != outer else None
    return _Slot(Bar(rect((tip, inner), (middle - half, middle + half)), along_x), bank)


def _slot_cells(canvas: Canvas, spec: PatternSpec) -> int:
    """How wide a pinch leaves a slot, in cells."""
    lattice = canvas.lattice
    dark = min(round(SLOT * lattice.per_module), lattice.whole(DARK_MM))
    return max(lattice.whole(spec.gap_mm), dark, round(LEAST_SLOT_MODULES * lattice.per_module))


def _is_free(canvas: Canvas, bridge: Bridge, spec: PatternSpec) -> bool:
    """Whether a bar has straight banks, and void along both sides, as far as a gap beyond it."""
    x0, y0, x1, y1 = canvas.rect(bridge)
    gap = canvas.lattice.whole(spec.gap_mm)
    if bridge.start[1] == bridge.end[1]:
        across = Rect(x0 - 1, y0 - gap, x1 + 1, y1 + gap).of(canvas.solid).T
    else:
        across = Rect(x0 - gap, y0 - 1, x1 + gap, y1 + 1).of(canvas.solid)
    sides = np.delete(across[1:-1], np.s_[gap:-gap], axis=1)
    return bool(across[0].all() and across[-1].all() and not sides.any())


def _cell(canvas: Canvas, point: tuple[float, float]) -> tuple[int, int]:
    """The lattice point of a point in modules of the symbol."""
    u, edge = canvas.lattice.per_module, canvas.lattice.quiet * canvas.lattice.per_module
    return round(edge + point[0] * u), round(edge + point[1] * u)
