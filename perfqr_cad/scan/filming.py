"""Pictures of views are made and read: which decoders read the right payload in which view."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.progress import counter
from perfqr_cad.scan.camera.camera import View
from perfqr_cad.scan.camera.look import Look
from perfqr_cad.scan.camera.scene import jittered
from perfqr_cad.scan.decoding.panel import Panel
from perfqr_cad.scan.schedule import FRONTAL_FRAMES, NEARER


class Subject(Protocol):
    """What can be filmed: a `Scene` or a `FlatPrint`."""

    def prepare(self, look: Look) -> None: ...

    def photo(self, view: View, look: Look | None = None, *, seed: int = 0) -> NDArray[np.uint8]: ...


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
    return lambda: subject.photo(seen, look, seed=picture_seed(seed, index, frame))


def picture_seed(seed: int, view: int, frame: int) -> int:
    """A seed of its own for the noise of every picture."""
    return int(np.random.SeedSequence([seed, view, frame]).generate_state(1)[0])
