"""What shipped templates share: from the parameters people set to the settings of `make`."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from perfqr_cad.request import read_holes

# Parameters and the settings they are.
SETTINGS = {
    "level": "level",
    "version": "version",
    "size": "size_mm",
    "quiet": "quiet_modules",
    "tone": "tone",
    "colour": "colour",
    "ground": "ground",
    "style": "style",
    "fillet": "fillet_mm",
    "finder": "finder",
    "objective": "objective",
    "thickness": "thickness_mm",
    "draft": "draft_deg",
    "lip": "lip_mm",
    "depth": "depth_mm",
    "nozzle": "nozzle_mm",
    "material": "material",
    "frame": "frame_mm",
    "corner_radius": "corner_radius_mm",
    "caption": "caption",
    "caption_height": "caption_height_mm",
    "caption_relief": "caption_relief_mm",
    "caption_place": "caption_place",
    "font": "font",
    "backing": "backing_mm",
    "gap": "backing_gap_mm",
    "pressure": "pressure_mpa",
    "finger": "finger_n",
    "own_weight": "own_weight",
    "support": "support",
    "yield_": "yield_mpa",
    "verify_solid": "verify_solid",
    "scan_tilt": "scan_tilt_deg",
    "seed": "seed",
}
# What leaves the choice to the program: 0 or nothing for some, a value below 0 for others.
CHOSEN_IF_EMPTY = (
    "version",
    "colour",
    "ground",
    "size",
    "depth",
    "caption_height",
    "font",
    "backing",
    "yield_",
    "scan_tilt",
)
CHOSEN_BELOW_0 = ("fillet", "draft", "lip")


def settings(p: SimpleNamespace) -> dict[str, Any]:
    """The settings of `perfqr_cad.make` that a template's parameters hold: `make(**settings(p), target=…)`.

    A picture is taken instead of the text; `hole` lists holes as `request.read_holes` reads them.
    """
    given = vars(p)
    image = given.get("image") or None
    made: dict[str, Any] = {"text": None if image else given["text"], "image": image}
    if "hole" in given:
        made |= read_holes(p.hole)
    for name, setting in SETTINGS.items():
        if name in given:
            left_open = (name in CHOSEN_IF_EMPTY and not given[name]) or (
                name in CHOSEN_BELOW_0 and given[name] < 0
            )
            made[setting] = None if left_open else given[name]
    return made
