"""sRGB bytes of linear light (IEC 61966-2-1)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

SHOULDER = 0.7  # linear light from which a picture's tones are compressed towards white


def coded(light: NDArray[Any]) -> NDArray[np.uint8]:
    """sRGB bytes of linear light in 0 to 1."""
    value = np.clip(light, 0.0, 1.0)
    return np.rint(
        255 * np.where(value <= 0.0031308, 12.92 * value, 1.055 * value ** (1 / 2.4) - 0.055)
    ).astype(np.uint8)


def exposed(light: NDArray[Any]) -> NDArray[np.uint8]:
    """sRGB bytes of linear light of any strength, with a soft shoulder to white."""
    over = np.maximum(light - SHOULDER, 0.0) / (1 - SHOULDER)
    return coded(np.minimum(light, SHOULDER) + (1 - SHOULDER) * np.tanh(over))
