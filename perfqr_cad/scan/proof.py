"""The proof: film the part from many sides and count who reads exactly what it should say."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.errors import AnalysisError, CaptureError, SymbolError
from perfqr_cad.geometry import Triangles
from perfqr_cad.progress import counter
from perfqr_cad.scan import advice
from perfqr_cad.scan.camera.camera import View
from perfqr_cad.scan.camera.flat import FlatPrint, printed
from perfqr_cad.scan.camera.look import Look
from perfqr_cad.scan.camera.placing import place
from perfqr_cad.scan.camera.scene import Scene, jittered
from perfqr_cad.scan.colours import BACKGROUNDS, contrast, contrast_warning
from perfqr_cad.scan.decoding.decoders import CORE, accepted
from perfqr_cad.scan.decoding.panel import Panel, shared
from perfqr_cad.scan.report import DecoderResult, FilmedView, ScanReport
from perfqr_cad.surface import Placement
from perfqr_cad.symbol import Matrix

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern


# Whether a part reads at all must not hang on the noise of one frame, nor on one distance: who scans from
# straight above moves the phone until it reads. Picture sizes of the frontal frames, of the schedule's own.
NEARER = (1.0, 1.25, 0.8, 1.25, 1.5)
FRONTAL_FRAMES = len(NEARER)
# The paper gives a scanner 2 s. A phone decodes ten frames and more in that time, of which these are tried.
PATIENCE = 3
SCANS = 2  # of every background


@dataclass(frozen=True)
class Schedule:
    """Which views are filmed. Tilts rise from 0; each is filmed from every azimuth.

    frames   a view is missed when this many frames of an unsteady hand are; the frontal view always gets
             `FRONTAL_FRAMES`
    """

    tilts_deg: tuple[float, ...]
    azimuths_deg: tuple[float, ...]
    frames: int = 1
    backgrounds: tuple[str, ...] = ()
    size_px: int = 800

    def patience(self) -> list[int]:
        """Frames for each of the views."""
        return [
            max(self.frames, FRONTAL_FRAMES) if view.tilt_deg == 0 else self.frames for view in self.views()
        ]

    def views(self) -> list[View]:
        """Every view, the frontal one once.

        >>> [(view.tilt_deg, view.azimuth_deg) for view in Schedule((0.0, 30.0), (65.0, 205.0)).views()]
        [(0.0, 65.0), (30.0, 65.0), (30.0, 205.0)]
        """
        return [
            View(tilt, azimuth, size_px=self.size_px)
            for tilt in self.tilts_deg
            for azimuth in (self.azimuths_deg if tilt > 0 else self.azimuths_deg[:1])
        ]


# Off the code's axes: walls of both directions show.
QUICK = Schedule((0.0, 20.0, 30.0), (65.0, 205.0), size_px=640)
FULL = Schedule(
    (0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0),
    (25.0, 115.0, 205.0, 295.0),
    frames=PATIENCE,
    backgrounds=tuple(BACKGROUNDS),
)


class Subject(Protocol):
    """What can be filmed: a `Scene` or a `FlatPrint`."""

    def prepare(self, look: Look) -> None: ...

    def photo(self, view: View, look: Look | None = None, *, seed: int = 0) -> NDArray[np.uint8]: ...


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
) -> ScanReport:
    """Film a solid and report which decoders read the exact payload, beside the flat print of the same code.

    placement   where the code lies; None: on the top of the mesh, the reader above
    pattern     gives the symbol of the flat print; None: it is read off the frontal view if that can be done
    payload     None: what the decoders that read the frontal view agree on
    decoders    names, or None for all that this machine has
    behind      a matte body of the ground's colour that is seen through the holes, such as the bottle in a
                ring; no part of the part

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
    film = partial(reads, look=look, right=right, panel=panel, seed=seed)
    patience = schedule.patience()
    read = film(scene, views, frames=patience, step="film the part")
    on_paper = _flat_print(scene, pattern, look, schedule)
    flat_read = None
    if on_paper is not None:
        flat_read = film(on_paper, views, frames=patience, step="film the flat print")
    colours = _backgrounds(scene, look, right, panel, schedule, read[0], seed)
    results = {
        name: DecoderResult(
            name, schedule.tilts_deg, _rates(name, schedule, views, read),
            None if flat_read is None else _rates(name, schedule, views, flat_read),
        )
        for name in panel.names
    }  # fmt: skip
    worst, first = _extremes(scene, views, look, read, panel.names, seed)
    inverted = pattern is not None and pattern.spec.tone == "inverted"
    light, dark = (look.ground, look.material) if inverted else (look.material, look.ground)
    losses = panel.losses.since(before)
    warnings = (
        *contrast_warning(contrast(light, dark), inverted=inverted),
        *(f"decoder {name} is left out: {reason}" for name, reason in panel.left_out.items()),
        *losses.sentences(),
    )
    report = ScanReport(_text(payload), results, colours, worst, first, (), warnings, losses)
    return replace(report, advice=advice.sentences(report))


def reads(
    subject: Subject,
    views: Sequence[View],
    look: Look,
    right: frozenset[bytes],
    panel: Panel,
    *,
    frames: Sequence[int] | None = None,
    seed: int = 0,
    step: str = "film",
) -> list[frozenset[str]]:
    """Names of the decoders that read one of the `right` payloads in each view.

    frames   how many frames of an unsteady hand each view gets until it is read; one each by default
    step     what the progress is announced as
    """
    frames = [1] * len(views) if frames is None else frames
    read: list[set[str]] = [set() for _ in views]
    announce = counter(step, sum(frames))
    announce(0)
    subject.prepare(look)
    for frame in range(max(frames, default=0)):
        waiting = [k for k in range(len(views)) if frame < frames[k] and len(read[k]) < len(panel.names)]
        to_come = sum(frames[k] - frame for k in waiting)
        pictures = [_picture(subject, views[k], look, seed, k, frame) for k in waiting]
        names = [[name for name in panel.names if name not in read[k]] for k in waiting]
        done = partial(_count, announce, sum(frames) - to_come)
        for k, reading in zip(waiting, panel.read_all(pictures, names=names, progress=done), strict=True):
            read[k] |= {name for name, payloads in reading.items() if right.intersection(payloads)}
    announce(sum(frames))
    return [frozenset(names) for names in read]


def _count(announce: Callable[[int], None], before: int, now: int) -> None:
    announce(before + now)


def _picture(
    subject: Subject, view: View, look: Look, seed: int, index: int, frame: int
) -> Callable[[], NDArray[np.uint8]]:
    """One frame of one view, made when it is called for; the first frame is the view itself."""
    seen = jittered(view, np.random.default_rng([seed, index, frame])) if frame else view
    if view.tilt_deg == 0:
        seen = replace(seen, size_px=round(seen.size_px * NEARER[frame % FRONTAL_FRAMES]))
    return lambda: subject.photo(seen, look, seed=_seed(seed, index, frame))


def _seed(seed: int, view: int, frame: int) -> int:
    """A seed of its own for the noise of every picture."""
    return int(np.random.SeedSequence([seed, view, frame]).generate_state(1)[0])


def _rates(
    name: str, schedule: Schedule, views: Sequence[View], read: Sequence[frozenset[str]]
) -> tuple[float, ...]:
    """Share of the azimuths at each tilt that one decoder reads."""
    hits = {tilt: [] for tilt in schedule.tilts_deg}
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


def _flat_print(scene: Scene, pattern: Pattern | None, look: Look, schedule: Schedule) -> FlatPrint | None:
    """The same symbol on paper, of the same size."""
    if pattern is not None:
        return printed(pattern.symbol.matrix.dark, pattern.size_mm, quiet_modules=pattern.quiet_modules)
    matrix = _matrix_seen(scene.photo(schedule.views()[0], look))
    return None if matrix is None else printed(matrix.dark, scene.part.code.edge_mm)


def _matrix_seen(picture: NDArray[np.uint8]) -> Matrix | None:
    """The corrected symbol in a frontal view, or None if it cannot be recovered."""
    from perfqr_cad.capture import read

    try:
        return read(picture).recovery.symbol.matrix
    except (CaptureError, SymbolError):
        return None


def _backgrounds(
    scene: Scene,
    look: Look,
    right: frozenset[bytes],
    panel: Panel,
    schedule: Schedule,
    readers: frozenset[str],
    seed: int,
) -> dict[str, float]:
    """Share of scans read on each ground, over the decoders that read the part frontally at all.

    A scan is a frontal view by an unsteady hand, given as many frames as any other view of the schedule.
    """
    still = [View(size_px=schedule.size_px)] * SCANS
    views = [jittered(view, np.random.default_rng([seed, k])) for k, view in enumerate(still)]
    rates: dict[str, float] = {}
    for ground in schedule.backgrounds:
        there = replace(look, ground=BACKGROUNDS[ground])
        frames = [schedule.frames] * SCANS
        read = reads(scene, views, there, right, panel, frames=frames, seed=seed, step=f"{ground} ground")
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
        picture = scene.photo(views[k], look, seed=_seed(seed, k, 0))
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
