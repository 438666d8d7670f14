"""Pictures moved and resized: the few OpenCV calls the camera needs, with their types kept."""

from __future__ import annotations

from typing import Literal, TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

Number = TypeVar("Number", np.uint8, np.float32)
Floats = NDArray[np.float64]
Beyond = Literal["black", "edge", "tiles"]
_BORDERS = {"black": cv2.BORDER_CONSTANT, "edge": cv2.BORDER_REPLICATE, "tiles": cv2.BORDER_WRAP}


def warp(
    picture: NDArray[Number],
    to_picture: Floats,
    size: tuple[int, int],
    *,
    beyond: Beyond = "black",
) -> NDArray[Number]:
    """The picture (h, w) under a homography (3, 3) of its (x, y), as a picture of `size` (width, height).

    Bilinear; beyond the picture lies black, its edge drawn out, or the picture again.
    """
    border = _BORDERS[beyond]
    moved = cv2.warpPerspective(picture, to_picture, size, flags=cv2.INTER_LINEAR, borderMode=border)
    return np.asarray(moved, picture.dtype)


def sample(picture: NDArray[Number], at: NDArray[np.float32]) -> NDArray[Number]:
    """Values (k,) at the positions (2, k): x and y in pixels; bilinear, zero beyond the picture.

    OpenCV takes at most 32766 positions at a time.
    """
    if at.shape[1] == 0:
        return np.zeros(0, picture.dtype)
    found = cv2.remap(
        picture, at[:1], at[1:], cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=0
    )
    return np.asarray(found, picture.dtype)[0]


def shift(picture: NDArray[np.float32], x: float, y: float, outside: float) -> NDArray[np.float32]:
    """Each pixel's value (x, y) pixels away from it; `outside` where that is beyond the picture."""
    matrix = np.array([[1.0, 0, x], [0, 1.0, y]])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    height, width = picture.shape
    moved = cv2.warpAffine(
        picture, matrix, (width, height), flags=flags, borderMode=cv2.BORDER_CONSTANT, borderValue=outside
    )
    return np.asarray(moved, np.float32)


def shrunk(picture: NDArray[Number], size: tuple[int, int]) -> NDArray[Number]:
    """The picture at a lower resolution (width, height), by area."""
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), picture.dtype)


def resized(picture: NDArray[np.float32], size: int) -> NDArray[np.float32]:
    """A square picture with `size` pixels on a side: by area when that is fewer, else bilinear."""
    how = cv2.INTER_AREA if size < len(picture) else cv2.INTER_LINEAR
    return np.asarray(cv2.resize(picture, (size, size), interpolation=how), np.float32)


def smooth(picture: NDArray[np.float32], sigma_px: float) -> NDArray[np.float32]:
    """Gaussian blur."""
    return np.asarray(cv2.GaussianBlur(picture, (0, 0), sigma_px), np.float32)


def slopes(picture: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Derivatives to the right and downwards (Sobel)."""
    right, down = cv2.Sobel(picture, -1, 1, 0), cv2.Sobel(picture, -1, 0, 1)
    return np.asarray(right, np.float32), np.asarray(down, np.float32)


def zoom(scale: float) -> Floats:
    """(3, 3) from pixels of a picture `scale` times smaller to the large one's; centres at whole numbers."""
    return np.array([[scale, 0, (scale - 1) / 2], [0, scale, (scale - 1) / 2], [0, 0, 1.0]])
