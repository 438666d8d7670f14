"""From which side a written part shows its code: it is filmed along its axes and the decoders tell."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.geometry import Triangles
from perfqr_cad.scan.camera.camera import View
from perfqr_cad.scan.camera.look import Look
from perfqr_cad.scan.camera.placing import place
from perfqr_cad.scan.camera.scene import Scene
from perfqr_cad.scan.decoding.panel import Panel

# The reader's right, up and outward by side; the top first, then the sides, upright.
SIDES: dict[str, tuple[tuple[int, int, int], ...]] = {
    "top": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "front (-y)": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    "right (+x)": ((0, 1, 0), (0, 0, 1), (1, 0, 0)),
    "back (+y)": ((-1, 0, 0), (0, 0, 1), (0, 1, 0)),
    "left (-x)": ((0, -1, 0), (0, 0, 1), (-1, 0, 0)),
    "bottom": ((1, 0, 0), (0, -1, 0), (0, 0, -1)),
}
TOUCHING_MM = 1e-3  # a backing that touches the plate lies behind it
CARD_NOTE = (
    "light from the far inner wall fills the holes of a hollow part: it was filmed with a card of the "
    "ground's colour through its middle, in place of what will stand in it"
)


BACKING_NOTE = "the backing in this file was taken to be of the ground's colour, as its design.json says"
BODIES_NOTE = (
    "all {count} bodies of this file were filmed in the part's colour: a backing in a colour of its own is "
    "known from the design.json only"
)


def turned(
    triangles: Triangles, panel: Panel, right: frozenset[bytes] | None, *, backed: bool = False
) -> tuple[Triangles, Triangles | None, tuple[str, ...]]:
    """The part turned so that the side with the code looks along z, a card to put behind it, and notes.

    right    the payloads that count; None: any
    backed   whether bodies wholly behind the highest one are a backing of the ground's colour

    Every other body is part of the scene. A plate that lies on its back stays as it is, and so does a part
    that is read from no side. The side that most decoders read is taken; a card is put inside when none reads
    without.
    """
    front = _frontmost(triangles) if backed else triangles
    if place(front).flat:
        return front, None, (BACKING_NOTE,) if front is not triangles else _bodies_note(triangles)
    for carded in (False, True):
        sides = {name: _seen_from(triangles, axes) for name, axes in SIDES.items()}
        cards = {name: _card(seen) if carded else None for name, seen in sides.items()}
        votes = {name: _readers(seen, cards[name], panel, right) for name, seen in sides.items()}
        best = max(votes, key=lambda name: votes[name])
        if votes[best]:
            notes = () if best == "top" else (f"the code was found on the {best}",)
            return sides[best], cards[best], (*notes, CARD_NOTE) if carded else notes
    return triangles, None, ()


def _bodies_note(triangles: Triangles) -> tuple[str, ...]:
    """What to say of a file with bodies one behind the other."""
    if _frontmost(triangles) is triangles:
        return ()
    return (BODIES_NOTE.format(count=triangles.body_count),)


def _frontmost(triangles: Triangles) -> Triangles:
    """The bodies of a file without those that lie wholly behind the highest one, seen along z."""
    faces, heights = np.asarray(triangles.faces, np.int64), np.asarray(triangles.vertices, float)[:, 2]
    if len(faces) == 0:
        return triangles
    body = triangles.vertex_components
    count = int(body.max()) + 1
    low, high = np.full(count, np.inf), np.full(count, -np.inf)
    np.minimum.at(low, body, heights)
    np.maximum.at(high, body, heights)
    top = high.argmax()
    behind = (high <= low[top] + TOUCHING_MM) & (np.arange(count) != top)
    if not behind.any():
        return triangles
    used, kept = np.unique(faces[~behind[body[faces[:, 0]]]], return_inverse=True)
    return Triangles(np.asarray(triangles.vertices)[used], kept.reshape(-1, 3))


def _readers(
    triangles: Triangles, card: Triangles | None, panel: Panel, right: frozenset[bytes] | None
) -> int:
    """How many decoders read a right payload from straight above."""
    reading = panel.read(Scene(place(triangles, behind=card)).photo(View(size_px=800), Look()))
    return sum(bool(found if right is None else right.intersection(found)) for found in reading.values())


def _seen_from(triangles: Triangles, axes: tuple[tuple[int, int, int], ...]) -> Triangles:
    turn = np.array(axes, float)
    return Triangles(np.asarray(triangles.vertices, float) @ turn.T, triangles.faces)


def _card(triangles: Triangles) -> Triangles:
    """A rectangle through the middle of a part's box, facing z."""
    vertices: NDArray[np.float64] = np.asarray(triangles.vertices, float)
    (x0, y0, z0), (x1, y1, z1) = vertices.min(axis=0), vertices.max(axis=0)
    z = (z0 + z1) / 2
    corners = np.array([[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]])
    return Triangles(corners, np.array([[0, 1, 2], [0, 2, 3]]))
