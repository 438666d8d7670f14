"""Draw a 3×3 halftone code of a flower, as input for `perfqr make --image`: `picture_code.py OUT.png`."""

import sys
from pathlib import Path

import numpy as np
import segno
from PIL import Image

target = Path(sys.argv[1] if len(sys.argv) > 1 else "out/picture.png")
code = segno.make("https://example.com/flower", error="h", version=5, micro=False)
dark = np.array([[bool(module) for module in row] for row in code.matrix])
n = len(dark)

y, x = np.mgrid[-1 : 1 : 3j * n, -1 : 1 : 3j * n]  # three submodules a module
petals = np.hypot(x, y) - 0.5 - 0.25 * np.cos(6 * np.arctan2(y, x))
shade = Image.fromarray(np.uint8(255 * (0.5 + 0.45 * np.tanh(8 * petals))))
art = np.array(shade.convert("1", dither=Image.Dither.FLOYDSTEINBERG)) == 0
art[1::3, 1::3] = dark  # the centre of every module tells its value

whole = np.kron(dark, np.ones((3, 3), bool))
corner, end, align = slice(0, 27), slice(-27, None), slice(-27, -12)
for part in ((corner, corner), (corner, end), (end, corner), (align, align), np.s_[18:21], np.s_[:, 18:21]):
    art[part] = whole[part]  # finders, format, alignment and timing stay whole

pixels = np.kron(np.pad(art, 12), np.ones((4, 4), bool))
target.parent.mkdir(parents=True, exist_ok=True)
Image.fromarray(np.uint8(np.where(pixels, 0, 255))).save(target)
