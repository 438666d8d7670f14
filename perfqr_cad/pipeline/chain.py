"""The chain: a `Request` becomes a `Design`, each step a free function of its own layer.

    text | picture -> symbol -> pattern -> placement -> strength -> solid -> scan

`run` is the only place where the layers meet.
"""

from __future__ import annotations

import time
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from perfqr_cad.errors import DesignError, NotHeldError
from perfqr_cad.export.colour_change import colour_changes
from perfqr_cad.pipeline.design import Design
from perfqr_cad.pipeline.held import advised, require_borne, require_known, require_read
from perfqr_cad.pipeline.holding import attempts
from perfqr_cad.pipeline.promises import of_code, promises, require_kept
from perfqr_cad.pipeline.request import CUT, SETTINGS, Request
from perfqr_cad.pipeline.resolve import Terms, resolve
from perfqr_cad.pipeline.setting import takes
from perfqr_cad.pipeline.source import source
from perfqr_cad.pipeline.targets import Site, Target, locate
from perfqr_cad.pipeline.tuning import for_grade, for_legibility, for_reader
from perfqr_cad.progress import tell

if TYPE_CHECKING:
    from perfqr_cad.capture import Art
    from perfqr_cad.geometry import Triangles
    from perfqr_cad.pattern import Pattern
    from perfqr_cad.scan import ScanReport
    from perfqr_cad.solid import Solid
    from perfqr_cad.surface import Placement


@takes(SETTINGS)
def make(
    text: str | None = None, *, image: str | Path | None = None, target: Target | None = None, **settings: Any
) -> Design:
    """Make a part from a text or a picture, with settings as listed below (the fields of `Request`).

    `target` is what the code is carved into; a flat plate of `thickness_mm` unless given.

    Raises `PerfQRError`: `SymbolError` and `CaptureError` for the code, `DesignError` for sizes and for a
    part that no decoder reads, `KernelError` for the solid, `AnalysisError` for the strength.
    """
    return run(asked(text, image=image, **settings), target)


def asked(text: str | None = None, *, image: str | Path | None = None, **settings: Any) -> Request:
    """The request that settings by name make. Raises `DesignError` for a name that is none."""
    known = Request.__dataclass_fields__
    for name in settings:
        if name not in known:
            raise DesignError(f"make() has no setting {name!r}: it has {', '.join(known)}")
    return Request(text=text, image=None if image is None else str(image), **settings)


def run(request: Request, target: Target | None = None) -> Design:
    """The whole chain for one request.

    Raises `NotHeldError` when the part is weak or unread where it was asked not to be; its message names a
    change with which the part was made and holds, or says what was tried.
    """
    shortfalls: list[NotHeldError] = []
    for attempt in attempts(request, plate=target is None):
        try:
            return _once(attempt, target)
        except NotHeldError as shortfall:
            shortfalls.append(shortfall)
    raise advised(shortfalls[0], request, lambda tried: _once(tried, target), plate=target is None)


def _once(request: Request, target: Target | None) -> Design:
    from perfqr_cad import pattern as patterns
    from perfqr_cad import structure

    watch = _Stopwatch()
    require_known(request)
    terms = resolve(request, plate=target is None)
    with watch("symbol"):
        found = source(request, terms)
    with watch("pattern"):
        art = for_legibility(
            terms,
            found,
            lambda art: patterns.build(found.symbol, terms.drawing, art),
            request.thickness_mm,
        )
        terms, drawn = for_grade(
            terms, lambda terms: patterns.build(found.symbol, terms.drawing, art), request.thickness_mm
        )
    require_kept(of_code(drawn))
    with watch("placement"):
        site = locate(target, terms, drawn.extent_mm)
    if request.scan_tilt_deg and request.process not in CUT:
        with watch("tuning"):
            terms = for_reader(terms, drawn, site.placement.thickness_mm, plate=target is None)
        if target is None:  # its thickness may be another now
            site = locate(target, terms, drawn.extent_mm)
    case = terms.case_in(site.placement.thickness_mm)
    with watch("structure"):
        reinforced = structure.reinforce(drawn, site.placement, case, method=terms.method)
    require_borne(request, reinforced)
    verified = None
    if request.verify_solid:
        with watch("solid check"):
            verified = structure.verify_solid(reinforced.pattern, site.placement, case)
    with watch("solid"):
        solid = site.solid(reinforced.pattern, terms)
    if request.colour_change:
        colour_changes(solid)  # refused before the film, not after
    kept = promises(reinforced.pattern, solid)
    require_kept(kept)
    with watch("scan"):
        given = None if found.capture is None else found.capture.art
        report = _filmed(terms, site, solid, reinforced.pattern, given)
    require_read(request, report)
    return Design(
        terms.request,
        found,
        reinforced.pattern,
        site.placement,
        reinforced,
        solid,
        report,
        watch.seconds,
        verified,
        kept,
    )


def scan_part(path: str | Path, text: str | None = None) -> ScanReport:
    """Film a written part (.step, .stl, .3mf, or a design .json) with every decoder on this machine.

    Without `text` the payload is what the certificate says, or what the decoders agree on.
    """
    from perfqr_cad import scan
    from perfqr_cad.hosts.step.meshing import mesh_step

    return scan.part(path, text, mesh_step=mesh_step)


def _filmed(terms: Terms, site: Site, solid: Solid, pattern: Pattern, art: Art | None) -> ScanReport:
    """What the decoders make of the finished solid; of a stencil's, of the picture that is painted."""
    from perfqr_cad import scan
    from perfqr_cad.profile.sheets import PAINTED, STENCIL
    from perfqr_cad.symbol import payload_of

    painted = terms.request.process == STENCIL
    triangles, placement = _painted(pattern) if painted else (solid.triangles, site.placement)
    report = scan.certify(
        triangles,
        placement,
        pattern,
        payload_of(pattern.symbol).data,
        schedule=terms.views,
        look=terms.look,
        seed=terms.request.seed,
        behind=site.behind(solid),
        art=art,
    )
    return replace(report, warnings=(*report.warnings, PAINTED)) if painted else report


def _painted(pattern: Pattern) -> tuple[Triangles, Placement]:
    """What stays bare of a wall that is painted through a stencil, as a sheet of next to no thickness."""
    from perfqr_cad.profile import Profile
    from perfqr_cad.profile.sheets import PAINT_MM, bare
    from perfqr_cad.solid import build_profile
    from perfqr_cad.surface import Plane

    wall = Plane(PAINT_MM)
    first, *others = (build_profile(Profile((p,)), wall).triangles for p in bare(pattern.region))
    return first.joined(*others), wall


class _Stopwatch:
    """Seconds by step, announced as they begin."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def __call__(self, step: str) -> Generator[None]:
        tell(step)
        begin = time.perf_counter()
        yield
        self.seconds[step] = time.perf_counter() - begin
