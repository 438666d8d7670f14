"""Unit conversions. Inside the package: mm, N, MPa, degrees, seconds; only the edges convert."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

PA_PER_MPA = 1.0e6
MM3_PER_CM3 = 1.0e3


def mpa_from_pa(pressure_pa: float) -> float:
    """Pressure in MPa (N/mm²) from pascal: the paper's 5 Pa is 5e-6 MPa."""
    return pressure_pa / PA_PER_MPA


def grams(volume_mm3: float, density_kg_m3: float) -> float:
    """Mass in g of a volume in mm³ at a density in kg/m³."""
    return volume_mm3 / MM3_PER_CM3 * density_kg_m3 / 1000.0


def linear_from_srgb(value: ArrayLike) -> NDArray[np.float64]:
    """Linear light of sRGB components, both 0 to 1 (IEC 61966-2-1)."""
    value = np.asarray(value, np.float64)
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def srgb_from_linear(light: ArrayLike) -> NDArray[np.float64]:
    """sRGB components of linear light, both 0 to 1 (IEC 61966-2-1)."""
    light = np.asarray(light, np.float64)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
