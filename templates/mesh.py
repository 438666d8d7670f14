"""A code in a triangle mesh, such as the Bunny."""

from perfqr_cad import make
from perfqr_cad.solid.meshtarget import MeshTarget

# [Code]
# the text of the code
text = "https://example.com"
# error correction level
level = "M"  # [L:7 %, M:15 %, Q:25 %, H:30 %]
# edge of the code with its quiet zone, mm
size = 50.0  # [1:0.1:2000]
# light margin around the code, modules
quiet = 4  # [1:1:20]

# [Mesh]
# the STL, OBJ, PLY, OFF or 3MF file
mesh = ""
# longest edge of the body, mm; 0 takes the file's own size, times the scale
extent = 0.0  # [0:0.1:5000]
# factor on the file's coordinates
scale = 1.0
# number of one of several separate bodies, 1 the greatest; 0: there is one
part = 0  # [0:1:100000]
# thickness of the shell that the body is made into, mm; 0 leaves it as it is
hollow = 0.0  # [0:0.05:100]
# where the reader is, mm; none: the flattest spot
point = None
# where the reader looks; none: the nearest surface to the point
direction = None
# what points up in the code; none: +z, or +y where the spot looks along z
up = None
# blind pockets this deep, mm; 0: through the wall
depth = 0.0  # [0:0.05:500]
# the panel under the code as an exact B-spline solid, instead of the carved mesh
exact = False

# [Look]
# shape of the modules
style = "square"  # [square, rounded, dots, diamond, bars]
# radius of re-entrant corners, mm; -1 takes half the nozzle
fillet = -1  # [-1:0.05:5]
# width of one printed line or of the kerf, mm
nozzle = 0.4  # [0.05:0.05:2]

# [Strength]
# what the part is made of
material = "PLA"  # [PLA, PETG, ABS, PA12, resin, aluminium, steel, stainless]
# uniform pressure on the part, MPa
pressure = 5e-6


def build(p):
    target = MeshTarget(
        p.mesh,
        point=p.point,
        direction=p.direction,
        scale=p.scale,
        extent_mm=p.extent or None,
        hollow_mm=p.hollow or None,
        depth_mm=p.depth or None,
        part=p.part or None,
        up=p.up,
        exact=p.exact,
    )
    return make(
        p.text,
        target=target,
        level=p.level,
        size_mm=p.size,
        quiet_modules=p.quiet,
        style=p.style,
        fillet_mm=None if p.fillet < 0 else p.fillet,
        nozzle_mm=p.nozzle,
        material=p.material,
        pressure_mpa=p.pressure,
    )
