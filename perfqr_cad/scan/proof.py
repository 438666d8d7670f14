"""The proof: film the part from many sides and count who reads exactly what it should say."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.errors import AnalysisError, CaptureError, SymbolError
from perfqr_cad.geometry import Triangles
from perfqr_cad.scan import advice
from perfqr_cad.scan.camera.camera import View
from perfqr_cad.scan.camera.flat import FlatPrint, printed
from perfqr_cad.scan.camera.look import Look
from perfqr_cad.scan.camera.placing import place
from perfqr_cad.scan.camera.scene import Scene, jittered
from perfqr_cad.scan.colours import BACKGROUNDS, contrast, contrast_warning
from perfqr_cad.scan.decoding.decoders import CORE, accepted
from perfqr_cad.scan.decoding.panel import Losses, Panel, shared
from perfqr_cad.scan.filming import picture_seed, reads
from perfqr_cad.scan.grade import SymbolGrade, graded
from perfqr_cad.scan.grounds import GroundResult
from perfqr_cad.scan.likeness import Likeness, likeness
from perfqr_cad.scan.report import DecoderResult, FilmedView, ScanReport
from perfqr_cad.scan.schedule import QUICK, Schedule
from perfqr_cad.surface import Placement
from perfqr_cad.symbol import QUIET_MODULES, Symbol

if TYPE_CHECKING:
    from perfqr_cad.capture import Art
    from perfqr_cad.pattern import Pattern

Film = Callable[..., list[frozenset[str]]]  # `reads` with payload, panel and seed given
SCANS = 2  # of every coloured background
CORES = 2


def certify(
    triangles: Triangles,
    placement: Placement | None,
    pattern: Pattern | None,
    payload: str | bytes | None,
    *,
    schedule: Schedule = QUICK,
    decoders: Sequence[str] | None = CORE,
    look: Look | None = None,
    seed: int = 0,
    behind: Triangles | None = None,
    art: Art | None = None,
) -> ScanReport:
    """Film a solid and report which decoders read the exact payload, beside the flat print of the same code.

    placement   where the code lies; None: on the top of the mesh, the reader above
    pattern     gives the symbol of the flat print; None: it is read off the frontal view if that can be done
    payload     None: what the decoders that read the frontal view agree on
    decoders    names, or None for all that this machine has
    behind      a matte body of the ground's colour that is seen through the holes, such as the bottle in a
                ring; no part of the part
    art         the picture that the pattern was drawn from: a flat print of it is filmed beside the part

    AnalysisError if a decoder is not available here, or if no payload was given and none can be read;
    KernelError if the mesh is empty.
    """
    look = look or Look()
    edge_mm = None if pattern is None else pattern.size_mm
    scene = Scene(place(triangles, placement, edge_mm=edge_mm, behind=behind))
    panel = shared(decoders)
    before = panel.losses
    if payload is None:
        payload = _agreed(scene, look, panel, schedule)
    right = accepted(payload)
    views = schedule.views()
    film = partial(reads, right=right, panel=panel, seed=seed)
    read = film(scene, views, look, frames=schedule.patience(views), step="film the part")
    symbol = _symbol_seen(scene.photo(views[0], look)) if pattern is None else pattern.symbol
    results = _results(
        schedule, views, read, panel.names, _flat_reads(film, scene, pattern, symbol, look, schedule)
    )
    grounds = () if schedule.ground_known else _grounds(film, scene, look, panel.names, schedule)
    worst, first = _extremes(scene, views, look, read, panel.names, seed)
    losses = panel.losses.since(before)
    report = ScanReport(
        _text(payload),
        results,
        _backgrounds(film, scene, look, schedule, read[0], seed),
        worst,
        first,
        warnings=_warnings(look, pattern, panel, losses),
        losses=losses,
        grade=None if symbol is None else _grade(scene, look, placement, pattern, symbol, schedule),
        look=look,
        grounds=grounds,
        likeness=None if art is None else _likeness(film, scene, art, pattern, look, schedule, panel.names),
    )
    return replace(report, advice=advice.sentences(report))


def _warnings(look: Look, pattern: Pattern | None, panel: Panel, losses: Losses) -> tuple[str, ...]:
    """What is wrong with the colours, and what the panel lacked."""
    inverted = _is_inverted(pattern)
    light, dark = (look.ground, look.material) if inverted else (look.material, look.ground)
    return (
        *contrast_warning(contrast(light, dark), inverted=inverted),
        *(f"decoder {name} is left out: {reason}" for name, reason in panel.left_out.items()),
        *losses.sentences(),
    )


def _is_inverted(pattern: Pattern | None) -> bool:
    """Whether the material is what should be dark."""
    return pattern is not None and pattern.spec.tone == "inverted"


def _flat_reads(
    film: Film,
    scene: Scene,
    pattern: Pattern | None,
    symbol: Symbol | None,
    look: Look,
    schedule: Schedule,
) -> list[frozenset[str]] | None:
    """Who reads the flat print of the code, in the schedule's flat views; None without a symbol."""
    if symbol is None:
        return None
    views = schedule.flat_views()
    frames = schedule.patience(views)
    return film(_flat_print(scene, pattern, symbol), views, look, frames=frames, step="film the flat print")


def _likeness(
    film: Film,
    scene: Scene,
    art: Art,
    pattern: Pattern | None,
    look: Look,
    schedule: Schedule,
    names: Sequence[str],
) -> Likeness:
    """The flat print of the art: who reads it, and how alike part and art are."""
    quiet = QUIET_MODULES if pattern is None else pattern.quiet_modules
    edge_mm = scene.part.code.edge_mm if pattern is None else pattern.size_mm
    inverted = _is_inverted(pattern)
    on_paper = printed(art.dark, edge_mm, quiet_modules=quiet, scale=art.scale, inverted=inverted)
    views = schedule.flat_views()
    read = film(on_paper, views, look, frames=schedule.patience(views), step="film the art")
    results = {
        name: DecoderResult(name, schedule.tilts_deg, _rates(name, schedule.tilts_deg, views, read), None)
        for name in names
    }
    return likeness(scene, on_paper, look, edge_mm, results)


def _results(
    schedule: Schedule,
    views: Sequence[View],
    read: Sequence[frozenset[str]],
    names: Sequence[str],
    flat_read: Sequence[frozenset[str]] | None,
) -> dict[str, DecoderResult]:
    """What each decoder read, by tilt, of the part and of the flat print."""
    flat_views = schedule.flat_views()
    return {
        name: DecoderResult(
            name,
            schedule.tilts_deg,
            _rates(name, schedule.tilts_deg, views, read),
            None if flat_read is None else _rates(name, schedule.tilts_deg, flat_views, flat_read),
        )
        for name in names
    }


def _grounds(
    film: Film, scene: Scene, look: Look, names: Sequence[str], schedule: Schedule
) -> tuple[GroundResult, ...]:
    """Who reads the part before other grounds and in other light; their light is worked out side by side."""
    views = schedule.ground_views()
    looks = [ground.look(look) for ground in schedule.grounds]
    with ThreadPoolExecutor(CORES) as pool:
        list(pool.map(scene.prepare, looks))
    found: list[GroundResult] = []
    for ground, there in zip(schedule.grounds, looks, strict=True):
        read = film(scene, views, there, step=f"before {ground.name}")
        tilts_deg = schedule.ground_tilts_deg
        rates = {name: _rates(name, tilts_deg, views, read) for name in names}
        found.append(GroundResult(ground, tilts_deg, rates))
    return tuple(found)


def _rates(
    name: str, tilts_deg: Sequence[float], views: Sequence[View], read: Sequence[frozenset[str]]
) -> tuple[float, ...]:
    """Share of the azimuths at each tilt that one decoder reads."""
    hits = {tilt: [] for tilt in tilts_deg}
    for view, names in zip(views, read, strict=True):
        hits[view.tilt_deg].append(name in names)
    return tuple(float(np.mean(hit)) for hit in hits.values())


def _agreed(scene: Scene, look: Look, panel: Panel, schedule: Schedule) -> bytes:
    """What the decoders that read the part from straight above say, if it is one thing."""
    view = schedule.views()[0]
    readings = panel.read(scene.photo(view, look))
    said = {payload for payloads in readings.values() for payload in payloads}
    if len(said) != 1:
        found = "nothing" if not said else f"{len(said)} different payloads"
        raise AnalysisError(
            f"{len(panel.names)} decoders read {found} from straight above: give the text that it must show"
        )
    return said.pop()


def _flat_print(scene: Scene, pattern: Pattern | None, symbol: Symbol) -> FlatPrint:
    """The same symbol on paper, of the same size."""
    dark = symbol.matrix.dark
    if pattern is None:
        return printed(dark, scene.part.code.edge_mm)
    return printed(dark, pattern.size_mm, quiet_modules=pattern.quiet_modules, inverted=_is_inverted(pattern))


def _symbol_seen(picture: NDArray[np.uint8]) -> Symbol | None:
    """The corrected symbol in a frontal view, or None if it cannot be recovered."""
    from perfqr_cad.capture import read

    try:
        return read(picture).recovery.symbol
    except (CaptureError, SymbolError):
        return None


def _grade(
    scene: Scene,
    look: Look,
    placement: Placement | None,
    pattern: Pattern | None,
    symbol: Symbol,
    schedule: Schedule,
) -> SymbolGrade:
    """How a verifier would grade the part."""
    if pattern is None:
        quiet, module_mm = QUIET_MODULES, scene.part.code.edge_mm / (symbol.size + 2 * QUIET_MODULES)
    else:
        frame = int(pattern.spec.surround.frame_mm / pattern.module_mm)
        quiet, module_mm = pattern.quiet_modules + frame, pattern.module_mm
    return graded(
        scene, look, symbol,
        module_mm=module_mm, quiet=quiet, ground_known=schedule.ground_known,
        on_surface=None if placement is None else placement.point,
    )  # fmt: skip


def _backgrounds(
    film: Film, scene: Scene, look: Look, schedule: Schedule, readers: frozenset[str], seed: int
) -> dict[str, float]:
    """Share of scans read on each coloured ground, over the decoders that read the part frontally at all.

    A scan is one frame of a frontal view by an unsteady hand.
    """
    still = [View(size_px=schedule.size_px)] * SCANS
    views = [jittered(view, np.random.default_rng([seed, k])) for k, view in enumerate(still)]
    rates: dict[str, float] = {}
    for ground in schedule.backgrounds:
        there = replace(look, ground=BACKGROUNDS[ground])
        read = film(scene, views, there, frames=[1] * SCANS, step=f"{ground} ground")
        rates[ground] = sum(len(names & readers) for names in read) / (SCANS * max(len(readers), 1))
    return rates


def _extremes(
    scene: Scene,
    views: Sequence[View],
    look: Look,
    read: Sequence[frozenset[str]],
    names: Sequence[str],
    seed: int,
) -> tuple[FilmedView | None, FilmedView | None]:
    """The steepest view that all frontal readers still read, and the first that one of them misses."""
    frontal = read[0]
    worst: int | None = None
    first: int | None = None
    for k in np.argsort([view.tilt_deg for view in views], kind="stable"):
        if frontal and frontal <= read[k]:
            worst = int(k)
        elif first is None:
            first = int(k)

    def filmed(k: int | None) -> FilmedView | None:
        if k is None:
            return None
        picture = scene.photo(views[k], look, seed=picture_seed(seed, k, 0))
        readers = tuple(name for name in names if name in read[k])
        return FilmedView(picture, views[k].tilt_deg, views[k].azimuth_deg, readers)

    return filmed(worst), filmed(first)


def _text(payload: str | bytes) -> str | None:
    if isinstance(payload, str):
        return payload
    try:
        return payload.decode()
    except UnicodeDecodeError:
        return None
