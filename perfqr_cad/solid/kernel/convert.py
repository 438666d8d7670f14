"""One kernel shape, many wrappers: nothing is written to a file or copied on the way."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from perfqr_cad.errors import KernelError

if TYPE_CHECKING:
    import build123d
    import cadquery
    from OCP.TopoDS import TopoDS_Shape

    from perfqr_cad.solid.shape import Solid


def shape_of(part: Solid | Any) -> TopoDS_Shape:
    """The kernel shape of a `Solid`, a build123d object, a CadQuery object or workplane, or a shape itself.

    Raises `KernelError` for a carved mesh, which has triangles only.
    """
    if callable(getattr(part, "vals", None)):  # a CadQuery workplane
        part = part.val()
    part = getattr(part, "part", part)  # a build123d builder
    if hasattr(part, "wrapped"):
        from perfqr_cad.solid.kernel.booleans import solids

        found = solids(part.wrapped)
        return found[0] if len(found) == 1 else part.wrapped
    if hasattr(part, "triangles") and part.shape is None:
        raise KernelError(
            f"{part.name!r} has triangles only: write it as STL or 3MF, or ask for an exact panel"
        )
    return getattr(part, "shape", part)


def to_build123d(part: Solid | Any) -> build123d.Part:
    """The same shape as a build123d `Part`, with its name and colour."""
    import build123d

    made = build123d.Part(build123d.Compound([build123d.Solid(shape_of(part))]).wrapped)
    made.label = getattr(part, "name", "") or getattr(part, "label", "")
    colour = getattr(part, "colour", None)
    if colour is not None:
        made.color = build123d.Color(*colour)
    return made


def to_cadquery(part: Solid | Any) -> cadquery.Workplane:
    """The same shape as a CadQuery `Workplane` with one object."""
    import cadquery

    return cadquery.Workplane(obj=cadquery.Shape.cast(shape_of(part)))
