"""A hollow ball with the code projected on it."""

from build123d import Sphere

from perfqr_cad import make
from perfqr_cad.catalog.settings import settings
from perfqr_cad.hosts.step import ImportedFace

# [Code]
# the text of the code
text = "https://example.com"
# a picture of an artistic code, instead of the text
image = ""
# error correction level
level = "M"  # [L:7 %, M:15 %, Q:25 %, H:30 %]
# symbol version; 0 takes the smallest that fits
version = 0  # [0:1:40]
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
# how the finder rings are held
finder = "recessed"  # [recessed:at the back, panel:flush bars, diagonal:four corner bars]
# how bridges are chosen
objective = "optimal"  # [optimal:fewest and least harmful, paper:Eq. (4)]

# [Walls]
# flare of the hole walls towards the back, degrees
draft = 0  # [0:1:60]
# straight lip in front of flared walls, mm
lip = 0  # [0:0.1:50]
# depth of blind pockets instead of through-holes, mm; 0 goes through
depth = 0  # [0:0.1:500]
# width of one printed line or of the kerf, mm
nozzle = 0.4  # [0.05:0.05:2]

# [Strength]
# what the part is made of
material = "PLA"  # [PLA, PETG, ABS, PA12, resin, aluminium, steel, stainless]
# uniform pressure on the part, MPa
pressure = 5e-6
# force of a fingertip at the worst place of the code, N
finger = 0  # [0:0.5:10000]
# whether the code's square carries its own weight, lying flat
own_weight = False
# how the code's square is held
support = "clamped"  # [clamped, simple, two-sides, corners]
# yield stress, MPa; 0 takes the material's
yield_ = 0
# check the strength once more in three dimensions
verify_solid = False

# [Proof]
# colour of the part: white, natural, yellow, orange, silver, red, green, blue, grey, black or #rrggbb
colour = ""
# colour behind it: white, black, red, green, blue, cyan, magenta, yellow or #rrggbb
ground = ""
# tilt at which the part must still read, degrees; 0 asks for nothing
scan_tilt = 0  # [0:5:60]
# seed of everything random
seed = 0  # [0:1:1000000]


def build(p):
    ball = Sphere(p.diameter / 2) - Sphere(p.diameter / 2 - p.thickness)
    front = (0.0, -p.diameter / 2, 0.0)
    return make(target=ImportedFace.of(ball, point=front, depth_mm=p.depth or None), **settings(p))
