"""A hollow ball with the code projected on it."""

from build123d import Sphere

from perfqr_cad import make
from perfqr_cad.solid.imported import ImportedFace

# [Code]
# the text of the code
text = "https://example.com"
# error correction level
level = "M"  # [L:7 %, M:15 %, Q:25 %, H:30 %]
# edge of the code with its quiet zone, mm; 0 takes the smallest that the nozzle prints
size = 0.0  # [0:0.1:2000]
# light margin around the code, modules
quiet = 4  # [1:1:20]

# [Ball]
# outer diameter, mm
diameter = 80.0  # [5:0.1:5000]
# thickness of the wall, mm
thickness = 1.6  # [0.1:0.1:50]

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
    ball = Sphere(p.diameter / 2) - Sphere(p.diameter / 2 - p.thickness)
    front = (0.0, -p.diameter / 2, 0.0)
    return make(
        p.text,
        target=ImportedFace.of(ball, point=front),
        level=p.level,
        size_mm=p.size or None,
        quiet_modules=p.quiet,
        style=p.style,
        fillet_mm=None if p.fillet < 0 else p.fillet,
        draft_deg=p.draft,
        nozzle_mm=p.nozzle,
        material=p.material,
        pressure_mpa=p.pressure,
    )
