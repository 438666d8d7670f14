"""One part per serial number: `python examples/label.py OUT_FOLDER [COUNT]`."""

import sys
from pathlib import Path

from perfqr_cad import make

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/labels")
count = int(sys.argv[2]) if len(sys.argv) > 2 else 3
folder.mkdir(parents=True, exist_ok=True)

for serial in range(1, count + 1):
    design = make(text=f"https://example.com/p/{serial:07d}", size_mm=60)
    design.write(folder / f"label-{serial:07d}.step")
    print(design.summary())
