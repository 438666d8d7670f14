"""Linear light as a picture shows it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.units import srgb_from_linear

SHOULDER = 0.7  # linear light from which a picture's tones are compressed towards white


def exposed(light: NDArray[Any]) -> NDArray[np.uint8]:
    """sRGB bytes of linear light of any strength, with a soft shoulder to white."""
    over = np.maximum(light - SHOULDER, 0.0) / (1 - SHOULDER)
    value = np.clip(np.minimum(light, SHOULDER) + (1 - SHOULDER) * np.tanh(over), 0.0, 1.0)
    return np.rint(srgb_from_linear(value) * 255).astype(np.uint8)
