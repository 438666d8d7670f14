"""Two tags on a tray: `Workplane.perforatedQR` in a CadQuery chain."""

import sys

import cadquery as cq

import perfqr_cad.solid.frontends.cadquery_plugin  # noqa: F401 - adds Workplane.perforatedQR

OUT = sys.argv[1] if len(sys.argv) > 1 else "tags.step"

tray = cq.Workplane().box(140, 70, 3).faces(">Z").workplane().pushPoints([(-35, 0), (35, 0)])
tags = tray.perforatedQR("https://example.com/t/1", 60, 2, combine=True)

cq.exporters.export(tags, OUT)
print(f"{tags.solids().size()} solid, {tags.val().Volume():.0f} mm³ -> {OUT}")
