"""sRGB and linear light (IEC 61966-2-1)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

SHOULDER = 0.7  # linear light from which a picture's tones are compressed towards white


def linear(colour: ArrayLike) -> NDArray[np.float64]:
    """Linear light of sRGB components in 0 to 1."""
    value = np.asarray(colour, np.float64)
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def exposed(light: NDArray[Any]) -> NDArray[np.uint8]:
    """sRGB bytes of linear light of any strength, with a soft shoulder to white."""
    over = np.maximum(light - SHOULDER, 0.0) / (1 - SHOULDER)
    value = np.clip(np.minimum(light, SHOULDER) + (1 - SHOULDER) * np.tanh(over), 0.0, 1.0)
    coded = np.where(value <= 0.0031308, 12.92 * value, 1.055 * value ** (1 / 2.4) - 0.055)
    return np.rint(coded * 255).astype(np.uint8)
