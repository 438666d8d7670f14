"""A code in the wall of your own STEP solid."""

from perfqr_cad import make
from perfqr_cad.solid.imported import ImportedFace

# [Code]
# the text of the code
text = "https://example.com"
# error correction level
level = "M"  # [L:7 %, M:15 %, Q:25 %, H:30 %]
# edge of the code with its quiet zone, mm
size = 40.0  # [1:0.1:2000]
# light margin around the code, modules
quiet = 4  # [1:1:20]

# [Solid]
# the STEP file
solid = ""
# name or number of a part, for an assembly
part = ""
# number of the face as CAD programs count, from 1; 0: by the point below, else the largest that takes the
# code
face = 0  # [0:1:1000000]
# where the reader is, mm; none: not used
point = None
# where the reader looks; none: the nearest surface to the point
direction = None
# what points up in the code; none: +z, or +y on faces that look along z
up = None
# lay the code along the face instead of projecting it
wrap = False
# blind pockets this deep, mm; 0: through the wall
depth = 0.0  # [0:0.05:500]

# [Look]
# shape of the modules
style = "square"  # [square, rounded, dots, diamond, bars]
# radius of re-entrant corners, mm; -1 takes half the nozzle
fillet = -1  # [-1:0.05:5]
# flare of the hole walls towards the back, degrees
draft = 0  # [0:1:60]
# width of one printed line or of the kerf, mm
nozzle = 0.4  # [0.05:0.05:2]

# [Strength]
# what the part is made of
material = "PLA"  # [PLA, PETG, ABS, PA12, resin, aluminium, steel, stainless]
# uniform pressure on the part, MPa
pressure = 5e-6


def build(p):
    target = ImportedFace(
        p.solid,
        face=p.face or None,
        point=p.point,
        direction=p.direction,
        part=p.part or None,
        up=p.up,
        wrap=p.wrap,
        depth_mm=p.depth or None,
    )
    return make(
        p.text,
        target=target,
        level=p.level,
        size_mm=p.size,
        quiet_modules=p.quiet,
        style=p.style,
        fillet_mm=None if p.fillet < 0 else p.fillet,
        draft_deg=p.draft,
        nozzle_mm=p.nozzle,
        material=p.material,
        pressure_mpa=p.pressure,
    )
