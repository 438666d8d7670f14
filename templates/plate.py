"""A flat plate with a perforated code."""

from perfqr_cad import make
from perfqr_cad.templating import settings

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
size = 0  # [0:0.1:2000]
# light margin around the code, modules
quiet = 4  # [1:1:20]
# which modules are material
tone = "normal"  # [normal:light modules, inverted:dark modules]

# [Look]
# shape of the modules
style = "square"  # [square, rounded, dots, diamond, bars]
# radius of re-entrant corners, mm; -1 takes half the nozzle
fillet = -1  # [-1:0.05:5]
# how the finder rings are held
finder = "recessed"  # [recessed:at the back, panel:flush bars, diagonal:four corner bars]
# how bridges are chosen
objective = "optimal"  # [optimal:fewest and least harmful, paper:Eq. (4)]

# [Body]
# thickness of the plate, mm
thickness = 1.6  # [0.1:0.1:50]
# flare of the hole walls towards the back, degrees; -1 flares where it helps the reader
draft = -1  # [-1:1:60]
# straight lip in front of flared walls, mm; -1 suits the flare
lip = -1  # [-1:0.1:50]
# depth of blind pockets instead of through-holes, mm; 0 goes through
depth = 0  # [0:0.1:50]
# frame around the quiet zone, mm
frame = 0  # [0:0.5:200]
# radius of the outer corners, mm
corner_radius = 0  # [0:0.5:200]
# mounting holes in the frame, mm: 3 for one in each corner, or x,y,diameter; x,y,diameter
hole = ""
# text on the frame; a new line begins another line
caption = ""
# on which side of the code it stands
caption_place = "bottom"  # [bottom:below, top:above]
# its font: the name of an installed one, or a file; nothing takes the one that comes along
font = ""
# height of its capital letters, mm; 0 takes half of the frame, or what its lines leave
caption_height = 0  # [0:0.1:200]
# how far letters stand out of the face, mm; below 0 they are engraved
caption_relief = 0.4  # [-10:0.1:10]
# thickness of a plate behind the part, in the tone of the holes, mm; 0 for none
backing = 0  # [0:0.1:50]
# gap before that plate, mm
gap = 0  # [0:0.1:50]
# width of one printed line or of the kerf, mm
nozzle = 0.4  # [0.05:0.05:2]

# [Strength]
# what the part is made of
material = "PLA"  # [PLA, PETG, ABS, PA12, resin, aluminium, steel, stainless]
# uniform pressure on the part, MPa
pressure = 5e-6
# force of a fingertip at the worst place, N
finger = 0  # [0:0.5:10000]
# whether the plate lies flat under its own weight
own_weight = False
# how the plate is held
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
    return make(**settings(p))
