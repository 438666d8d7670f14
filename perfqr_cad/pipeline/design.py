"""The pipeline: a `Request` becomes a `Design`, once round the chain.

    text | picture -> symbol -> pattern -> placement -> strength -> solid -> scan

`make` is the only place where the links meet; every link is a free function of its own layer.
"""

from __future__ import annotations

import time
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from perfqr_cad.errors import DesignError
from perfqr_cad.pipeline import resolve as terms
from perfqr_cad.pipeline.request import Request
from perfqr_cad.pipeline.targets import Sheet as Sheet
from perfqr_cad.pipeline.targets import Target, behind, dressed, plate
from perfqr_cad.progress import tell

if TYPE_CHECKING:
    import build123d
    import cadquery

    from perfqr_cad.capture import Capture
    from perfqr_cad.export import FileRecord
    from perfqr_cad.pattern import Pattern, PatternSpec
    from perfqr_cad.scan import ScanReport
    from perfqr_cad.solid import Solid
    from perfqr_cad.structure import Reinforcement, SolidCheck, StressField
    from perfqr_cad.surface import Placement
    from perfqr_cad.symbol import Level, Symbol


@dataclass(frozen=True)
class Design:
    """A finished part and everything that was measured on the way. Exporters read only this."""

    request: Request
    capture: Capture | None
    symbol: Symbol
    pattern: Pattern
    placement: Placement
    reinforcement: Reinforcement
    solid: Solid
    scan: ScanReport
    timings_s: dict[str, float] = field(default_factory=dict[str, float])
    verified: SolidCheck | None = None
    files: tuple[FileRecord, ...] = ()

    @property
    def stress(self) -> StressField:
        """The stress field of the finished part."""
        return self.reinforcement.after

    @property
    def mass_g(self) -> float:
        """Of the solid as it is, with its flared holes and all that it was carved into."""
        from perfqr_cad import structure
        from perfqr_cad.units import grams

        return grams(self.solid.volume_mm3, structure.material(self.request.material).density_kg_m3)

    @property
    def part(self) -> build123d.Part:
        """The part as a build123d object."""
        from perfqr_cad.solid.kernel.convert import to_build123d

        return to_build123d(self.solid)

    def workplane(self) -> cadquery.Workplane:
        """The part as a CadQuery object."""
        from perfqr_cad.solid.kernel.convert import to_cadquery

        return to_cadquery(self.solid)

    def certificate(self) -> dict[str, Any]:
        """Everything that was measured, as plain values; null where a link gave none."""
        from perfqr_cad.pipeline.certificate import certificate

        return certificate(self)

    def summary(self) -> str:
        """The certificate in a few lines for people."""
        from perfqr_cad.pipeline.certificate import summary

        return summary(self)

    def write(self, path: str | Path) -> FileRecord:
        """Write one file; its suffix is the format."""
        from perfqr_cad.export import write

        return write(self, path)

    def written(self, outputs: Sequence[str | Path]) -> Design:
        """Write files and folders; the design that knows of them."""
        from perfqr_cad.export import write_outputs

        begin = time.perf_counter()
        files = write_outputs(self, outputs)
        timings = self.timings_s | {"export": time.perf_counter() - begin}
        return replace(self, files=files, timings_s=timings)


def make(
    text: str | None = None, *, image: str | Path | None = None, target: Target | None = None, **settings: Any
) -> Design:
    """Make a part from a text or a picture; `settings` are the fields of `Request`.

    `target` is what the code is carved into; a flat plate of `thickness_mm` unless given.

    Raises `PerfQRError`: `SymbolError` and `CaptureError` for the code, `DesignError` for sizes and for a
    part that no decoder reads, `KernelError` for the solid, `AnalysisError` for the strength.
    """
    known = Request.__dataclass_fields__
    for name in settings:
        if name not in known:
            raise DesignError(f"make() has no setting {name!r}: it has {', '.join(known)}")
    return run(Request(text=text, image=None if image is None else str(image), **settings), target)


def run(request: Request, target: Target | None = None) -> Design:
    """The whole chain for one request."""
    from perfqr_cad import pattern as patterns
    from perfqr_cad import scan, structure

    watch = _Stopwatch()
    left_open = request.draft_deg is None
    request = terms.settled(request, plate=target is None)
    terms.walls(request)  # bad walls, captions, colours and materials are refused before the long steps
    terms.caption(request)
    terms.look(request)
    structure.material(request.material)
    with watch("symbol"):
        spec = terms.spec(request)
        capture, symbol = _source(request, spec)
    with watch("pattern"):
        drawn = patterns.build(symbol, spec, None if capture is None else capture.art)
    site = dressed(target or plate(request), request)
    with watch("placement"):
        placement = site.placement(drawn.extent_mm)
        terms.walls(request).require_fit(placement.thickness_mm)
    if request.scan_tilt_deg:
        with watch("tuning"):
            request = _tuned(request, drawn, placement.thickness_mm, is_plate=target is None)
        if target is None:  # its thickness may be another now
            site = dressed(plate(request), request)
            placement = site.placement(drawn.extent_mm)
    walls = terms.walls(request, or_straight=left_open)
    with watch("structure"):
        case = terms.case(request, walls.flare_mm(walls.reach_mm(placement.thickness_mm)))
        method = request.method
        reinforced = structure.reinforce(drawn, placement, case, method=method)  # pyright: ignore[reportArgumentType]
    verified = None
    if request.verify_solid:
        with watch("solid check"):
            verified = structure.verify_solid(reinforced.pattern, placement, case)
    with watch("solid"):
        solid = site.solid(reinforced.pattern, placement, walls)
        solid = replace(solid, colour=terms.part_colour(request))
    with watch("scan"):
        report = scan.certify(
            solid.triangles,
            placement,
            reinforced.pattern,
            _payload(symbol),
            plan=terms.plan(request),
            look=terms.look(request),
            seed=request.seed,
            behind=behind(site, solid, placement),
        )
    _require_readable(report, request.depth_mm, len(reinforced.bridges))
    return Design(
        request,
        capture,
        symbol,
        reinforced.pattern,
        placement,
        reinforced,
        solid,
        report,
        watch.seconds,
        verified,
    )


def scan_part(path: str | Path, text: str | None = None) -> ScanReport:
    """Film a written part (.step, .stl, .3mf, or a design .json) with every decoder on this machine.

    Without `text` the payload is what the certificate says, or what the decoders agree on.
    """
    from perfqr_cad import scan
    from perfqr_cad.hosts.step.meshing import mesh_step

    return scan.part(path, text, mesh_step=mesh_step)


def _source(request: Request, spec: PatternSpec) -> tuple[Capture | None, Symbol]:
    """The symbol of a text, masked so that its material hangs together, or of the code in a picture with its
    codewords corrected."""
    if request.image is not None:
        from perfqr_cad.capture import read

        capture = read(request.image)
        return capture, capture.recovery.symbol
    from perfqr_cad.pattern.choice import easiest_mask
    from perfqr_cad.symbol import encode

    assert request.text is not None  # Request holds exactly one of text and image
    level: Level = request.level  # pyright: ignore[reportAssignmentType]  # encode refuses other letters
    symbol = encode(request.text, version=request.version, level=level, mask=request.mask)
    return None, symbol if request.mask is not None else easiest_mask(symbol, spec)


def _tuned(request: Request, drawn: Pattern, thickness_mm: float, *, is_plate: bool) -> Request:
    """Walls, and a plate's thickness, for the tilt that is asked for."""
    from perfqr_cad.pipeline.tuning import for_reader

    return for_reader(request, drawn, _payload(drawn.symbol), thickness_mm, plate=is_plate)


def _payload(symbol: Symbol) -> bytes:
    from perfqr_cad.symbol import payload_of

    return payload_of(symbol).data


def _require_readable(report: ScanReport, depth_mm: float | None, strengthenings: int) -> None:
    """A part that no decoder reads is an error, not a warning."""
    if report.readers:
        return
    if depth_mm is not None:
        remedy = f"raise --size or --level, or take pockets deeper than {depth_mm:g} mm (--depth)"
    elif strengthenings:
        remedy = f"{strengthenings} bridges for strength cover it: raise --thickness, or lower the load"
    else:
        remedy = "raise --size or --level, or lower --thickness"
    tried = ", ".join(report.decoders)
    raise DesignError(
        f"none of {len(report.decoders)} decoders ({tried}) reads the part from straight above: {remedy}"
    )


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
