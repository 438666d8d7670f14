"""A code in the wall of your own STEP solid."""

from perfqr_cad import make, settings
from perfqr_cad.hosts.step import ImportedFace

# [Shared: Code]

# [Solid]
# the STEP file
solid = ""
# name or number of a part, for an assembly
part = ""
# number of the face as CAD programs count, from 1; none: by the point, else the largest that fits
face: int | None = None  # [1:1000000]
# where the reader is, mm; none: not used
point: tuple[float, float, float] | None = None
# where the reader looks; none: the nearest surface to the point
direction: tuple[float, float, float] | None = None
# what points up in the code; none: +z, or +y on faces that look along z
up: tuple[float, float, float] | None = None
# lay the code along the face instead of projecting it
wrap = False

# [Shared: Look, Walls, Strength, Proof, Files]


def build(p):
    at = {"point": p.point, "direction": p.direction, "up": p.up}
    target = ImportedFace(p.solid, face=p.face, part=p.part or None, wrap=p.wrap, **at)
    return make(target=target, **settings(p))
