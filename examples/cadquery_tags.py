"""Two codes in the windows of a tray: `Workplane.perforatedQR` in a CadQuery chain."""

import sys

import cadquery as cq

import perfqr_cad.frontends.cadquery_plugin  # noqa: F401 - adds Workplane.perforatedQR

OUT = sys.argv[1] if len(sys.argv) > 1 else "tags.step"

PLACES = [(-35, 0), (35, 0)]

# Each code rests on the rim of its window: a wall behind its holes would hide them.
tray = cq.Workplane().box(140, 70, 3).faces(">Z").workplane()
tray = tray.pushPoints(PLACES).rect(56, 56).cutThruAll()
tags = tray.pushPoints(PLACES).perforatedQR("https://example.com/t/1", 60, 2, combine=True)

cq.exporters.export(tags, OUT)
print(f"{tags.solids().size()} solid, {tags.val().Volume():.0f} mm³ -> {OUT}")
