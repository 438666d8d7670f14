"""A ring for a dark bottle: a band of a cylinder with the code wrapped around it."""

from build123d import Cylinder

from perfqr_cad import make
from perfqr_cad.solid.imported import ImportedFace, mesh_shape

# [Code]
# the text of the code
text = "https://example.com"
# error correction level
level = "M"  # [L:7 %, M:15 %, Q:25 %, H:30 %]
# edge of the code with its quiet zone, mm
size = 40.0  # [1:0.1:2000]
# light margin around the code, modules
quiet = 4  # [1:1:20]

# [Ring]
# outer diameter, mm
diameter = 80.0  # [5:0.1:5000]
# height, mm; 0 takes the code's
height = 0.0  # [0:0.1:5000]
# thickness of the wall, mm
thickness = 1.6  # [0.1:0.1:50]
# play between the ring and the bottle, in diameter, mm
clearance = 0.4  # [0.05:0.05:10]

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
    height = p.height or p.size
    ring = Cylinder(p.diameter / 2, height) - Cylinder(p.diameter / 2 - p.thickness, height)
    bottle = Cylinder(p.diameter / 2 - p.thickness - p.clearance / 2, height)
    front = (0.0, -p.diameter / 2, 0.0)
    return make(
        p.text,
        target=ImportedFace.of(ring, point=front, wrap=True, behind=mesh_shape(bottle)),
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
