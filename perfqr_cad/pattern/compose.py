"""From a symbol, or the art of a picture, to a pattern in one piece."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from perfqr_cad.errors import DesignError
from perfqr_cad.pattern.cells.brightness import solid_part
from perfqr_cad.pattern.cells.canvas import Canvas
from perfqr_cad.pattern.cells.corners import link_corners
from perfqr_cad.pattern.cells.lattice import Cells, label, rasterised
from perfqr_cad.pattern.cells.tidy import fill_slivers, tidy
from perfqr_cad.pattern.drawing.contours import mended, numbered_pieces
from perfqr_cad.pattern.drawing.size import least_dot_mm, module_size, rounded_up
from perfqr_cad.pattern.drawing.style import is_drawn, shaped_modules, style_holes
from perfqr_cad.pattern.joining.connect import join
from perfqr_cad.pattern.joining.paper import join_paper
from perfqr_cad.pattern.joining.rings import tie_rings
from perfqr_cad.pattern.pattern import Origin, Pattern, finish
from perfqr_cad.pattern.spec import PatternSpec
from perfqr_cad.remedy import Remedy
from perfqr_cad.symbol import Matrix, Readability, Symbol, readability

if TYPE_CHECKING:
    from perfqr_cad.capture import Art


GROWTH = 1.25  # from one size that is tried to the next
MOST_GROWTHS = 8
MOST_REJOINS = 3


def build(symbol: Symbol, spec: PatternSpec, art: Art | None = None) -> Pattern:
    """The pattern of a symbol in one piece; `art` replaces the plain modules by a picture's own.

    DesignError when the size is too small for the nozzle, or the result could not be read.

    >>> from perfqr_cad.symbol import encode
    >>> pattern = build(encode("HELLO"), PatternSpec(size_mm=40))
    >>> pattern.size_mm, pattern.polygon.geom_type, pattern.readability.total
    (40.0, 'Polygon', 0.0)
    """
    solid_is_dark = spec.tone == "inverted"
    right_solid = symbol.matrix.dark == solid_is_dark
    art = _kept(art, spec)
    canvas, reason = printable(symbol, spec, art)
    gap = canvas.lattice.whole(spec.gap_mm)
    islands = _islands(canvas, 1 if art is None else art.scale)
    canvas = tie_rings(canvas, symbol, spec)
    scale = 1 if art is None else art.scale
    sparing = scale > 1 and canvas.lattice.module_mm >= scale * least_dot_mm(spec, scale)
    losses: tuple[float, ...] = ()
    if spec.objective != "optimal":
        weight = spec.loss_weight if spec.objective == "paper" else 0.0
        canvas, losses = join_paper(canvas, symbol, spec.web_mm, weight, solid_is_dark, spec.seed)
    canvas = link_corners(canvas, spec.web_mm, spec.gap_mm, right_solid, sparing)
    canvas, optimality = join(canvas, symbol, scale, spec.web_mm, solid_is_dark, spec.most_nodes)
    if spec.objective != "optimal":
        optimality = None
    if not canvas.shapes:
        canvas = fill_slivers(canvas, right_solid, gap)
    canvas = link_corners(canvas, spec.web_mm, spec.gap_mm, right_solid, sparing)
    canvas, sound = rejoined(canvas, symbol, spec, scale, right_solid)
    if not sound:
        canvas, sound = mended(canvas, spec)
    return finish(canvas, Origin(symbol, spec, islands, reason, optimality, losses), sound)


def _kept(art: Art | None, spec: PatternSpec) -> Art | None:
    """The picture's own art, which a style that draws its modules anew has none of."""
    if art is None or not is_drawn(spec.style):
        return art
    if art.kind != "plain":
        raise DesignError(
            f"style {spec.style} draws plain modules, and the picture has {art.kind} art of its own",
            Remedy(style="square"),
        )
    return None


def _islands(canvas: Canvas, scale: int) -> int:
    """Pieces of the art as it was asked for; one cell of each of its samples tells."""
    step = 1 if canvas.shapes else canvas.lattice.per_module // scale
    return label(canvas.asked[::step, ::step])[1]


def rejoined(
    canvas: Canvas, symbol: Symbol, spec: PatternSpec, scale: int, right_solid: Cells
) -> tuple[Canvas, bool]:
    """Routes laid wherever less than the least web holds a piece; and whether all hold now."""
    for _ in range(MOST_REJOINS):
        if (pieces := numbered_pieces(canvas, spec)) is None:
            return canvas, True
        inverted = spec.tone == "inverted"
        canvas, _ = join(canvas, symbol, scale, spec.web_mm, inverted, spec.most_nodes, pieces)
        canvas = link_corners(canvas, spec.web_mm, spec.gap_mm, right_solid)
    return canvas, False


def printable(symbol: Symbol, spec: PatternSpec, art: Art | None) -> tuple[Canvas, str]:
    """The art with nothing thinner than the tool can make, and why the module has its size.

    A size that is not asked for grows until the clean-up loses no codeword that the art holds.
    """
    module_mm, reason = module_size(symbol, spec, art)
    solid_is_dark = spec.tone == "inverted"
    right_solid = symbol.matrix.dark == solid_is_dark
    lost = 0
    for _ in range(MOST_GROWTHS):
        asked = _asked(symbol, spec, art, module_mm)
        if asked.shapes:
            return asked, reason
        web, gap = asked.lattice.whole(spec.web_mm), asked.lattice.whole(spec.gap_mm)
        canvas = tidy(asked, right_solid, web, gap)
        held, kept = (_readability(d, symbol, solid_is_dark) for d in (asked, canvas))
        lost = sum(kept.errors) - sum(held.errors)
        if lost <= 0:
            return canvas, reason
        if spec.size_mm is not None:
            if math.isinf(kept.total) or (art is not None and art.kind == "halftone"):
                raise _too_small_for_art(symbol, spec, art, lost)
            return canvas, reason
        modules = symbol.size + 2 * spec.quiet_modules
        module_mm = rounded_up(module_mm * GROWTH * modules) / modules
        reason = (
            f"module {module_mm:.3g} mm: smaller ones lose codewords of the art to the {spec.web_mm:g} mm web"
        )
    raise DesignError(
        f"the art loses {lost} codewords to webs of {spec.web_mm:g} mm even at modules of"
        f" {module_mm:.3g} mm: use a finer nozzle or plainer art"
    )


def _too_small_for_art(symbol: Symbol, spec: PatternSpec, art: Art | None, lost: int) -> DesignError:
    enough, _ = printable(symbol, replace(spec, size_mm=None), art)
    least_size = rounded_up(enough.lattice.cells * enough.lattice.cell_mm)
    return DesignError(
        f"at size {spec.size_mm:g} mm webs of {spec.web_mm:g} mm cost the art {lost} codewords, limit 0",
        Remedy(size_mm=least_size),
        "a finer nozzle",
    )


def _readability(canvas: Canvas, symbol: Symbol, solid_is_dark: bool) -> Readability:
    observed = Matrix((solid_part(canvas.lattice) >= 0.5) == solid_is_dark)
    return readability(observed, symbol)


def _asked(symbol: Symbol, spec: PatternSpec, art: Art | None, module_mm: float) -> Canvas:
    """The art, or the plain modules in the style that was asked for, before anything is changed."""
    inverted = spec.tone == "inverted"
    if is_drawn(spec.style) and art is None:
        if inverted:
            raise DesignError(
                f"style {spec.style} draws holes, and in the tone inverted holes are light",
                Remedy(style="square"),
            )
        ground = symbol.matrix.dark & ~shaped_modules(symbol)
        lattice = rasterised(~ground, 1, spec.quiet_modules, module_mm, frame=True)
        canvas = Canvas(lattice, lattice.solid, lattice.solid)
        return canvas.with_shapes(style_holes(symbol, spec, lattice))
    dark = symbol.matrix.dark if art is None else art.dark
    scale = dark.shape[0] // symbol.size
    lattice = rasterised(dark == inverted, scale, spec.quiet_modules, module_mm, frame=not inverted)
    smooth_mm = 0.0
    if art is not None and art.kind == "freeform" and spec.contour == "smooth":
        smooth_mm = module_mm / art.scale
    return Canvas(lattice, lattice.solid, lattice.solid, smooth_mm=smooth_mm)
