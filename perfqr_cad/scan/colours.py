"""Colours of ground and filament as linear reflectances, and how much contrast they leave."""

from __future__ import annotations

import numpy as np

from perfqr_cad.scan.camera.look import BLACK, RGB, WHITE

# Saturated card: 80 % where it reflects and 5 % where it absorbs (typical of coated colour card).
_HIGH, _LOW = 0.8, 0.05
# The paper's six backgrounds (§6), in its order, and black.
BACKGROUNDS: dict[str, RGB] = {
    "black": BLACK,
    "red": (_HIGH, _LOW, _LOW),
    "green": (_LOW, _HIGH, _LOW),
    "blue": (_LOW, _LOW, _HIGH),
    "cyan": (_LOW, _HIGH, _HIGH),
    "magenta": (_HIGH, _LOW, _HIGH),
    "yellow": (_HIGH, _HIGH, _LOW),
}
# Filaments from light to dark; a dark one needs a light ground and an inverted pattern.
FILAMENTS: dict[str, RGB] = {
    "white": WHITE,
    "natural": (0.7, 0.66, 0.55),
    "yellow": (0.75, 0.6, 0.05),
    "orange": (0.7, 0.25, 0.05),
    "silver": (0.4, 0.4, 0.42),
    "red": (0.5, 0.05, 0.05),
    "green": (0.08, 0.35, 0.1),
    "blue": (0.05, 0.1, 0.45),
    "grey": (0.18, 0.18, 0.18),
    "black": BLACK,
}
LEAST_CONTRAST = 0.25  # below it, decoders begin to miss: a warning when the part is designed
# Engines that read none of eight codes with light and dark exchanged; zxing-cpp and WeChat read them.
REFUSE_REVERSED = "zbar, OpenCV, quirc, rxing and jsQR"
# ITU-R BT.709: luminance of linear red, green and blue.
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def contrast(material: RGB, ground: RGB) -> float:
    """Michelson contrast of the luminances, -1 to 1; negative when the ground is the lighter.

    >>> round(contrast(FILAMENTS["white"], BACKGROUNDS["black"]), 2)
    0.91
    """
    light, dark = float(LUMINANCE @ material), float(LUMINANCE @ ground)
    return (light - dark) / (light + dark)


def contrast_warning(value: float, *, inverted: bool = False) -> tuple[str, ...]:
    """One sentence when the contrast is too small or the wrong way round.

    value     contrast of what is to be light with what is to be dark
    inverted  whether the holes are what is to be light
    """
    if value >= LEAST_CONTRAST:
        return ()
    if value <= -LEAST_CONTRAST:
        lighter, tone = ("material", "normal") if inverted else ("ground", "inverted")
        return (
            f"the {lighter} is the lighter one ({value:.0%}): {REFUSE_REVERSED} refuse a code with light and "
            f"dark exchanged, so use the {tone} tone",
        )
    further = "a darker part or a lighter ground" if inverted else "a lighter part or a darker ground"
    return (f"contrast of material and ground is {value:.0%}, under {LEAST_CONTRAST:.0%}: choose {further}",)
