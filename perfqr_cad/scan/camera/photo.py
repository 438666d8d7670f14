"""From light to picture: colours, exposure, blur, motion, noise, gamma and compression."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from perfqr_cad.scan.camera.layers import Shot
from perfqr_cad.scan.camera.look import Look, Optics
from perfqr_cad.scan.camera.marching import Picture
from perfqr_cad.scan.camera.raster import warp

# The brightest thing in the picture is exposed to this part of full scale.
EXPOSURE = 0.85
LEVELS = 4095  # of a 12-bit sensor
DARKEST = 0.01  # of full scale: noise does not fall below that of this signal (read-out)
# ITU-R BT.601 luma, as camera previews and OpenCV compute it.
LUMA = np.array([0.299, 0.587, 0.114])


def develop(shot: Shot, look: Look, *, front: float, seed: int = 0) -> NDArray[np.uint8]:
    """Gray picture (H, W) of a shot. `front` is the irradiance of an open, level face."""
    if _is_gray(look):
        light = _channel(shot, look, 0)
        return _camera(light[..., None], look, front, seed)[..., 0]
    colour = develop_colour(shot, look, front=front, seed=seed)
    return np.asarray(cv2.cvtColor(colour, cv2.COLOR_RGB2GRAY), np.uint8)


def develop_colour(shot: Shot, look: Look, *, front: float, seed: int = 0) -> NDArray[np.uint8]:
    """Colour picture (H, W, 3), red first."""
    light = np.stack([_channel(shot, look, c) for c in range(3)], axis=-1)
    return _camera(light, look, front, seed)


def _is_gray(look: Look) -> bool:
    flat_texture = look.texture is None or look.texture.ndim == 2
    return flat_texture and len(set(look.material)) == 1 and len(set(look.ground)) == 1


def _channel(shot: Shot, look: Look, channel: int) -> Picture:
    """Light that one colour channel receives, linear."""
    ground = np.float32(look.ground[channel]) * shot.ground
    if look.texture is not None:
        ground *= _texture(shot, look, channel)
    lit = np.float32(look.material[channel]) * shot.material
    if look.translucency > 0:
        lit += np.float32(look.material[channel] * look.translucency * look.light.on_front) * shot.cover
    lit += ground
    return lit


def _texture(shot: Shot, look: Look, channel: int) -> NDArray[np.float32]:
    """The ground's texture as the camera sees it, tiled."""
    assert look.texture is not None
    tile = look.texture if look.texture.ndim == 2 else look.texture[..., channel]
    per_mm = tile.shape[1] / look.texture_mm
    mm_to_px = np.array([[per_mm, 0, tile.shape[1] / 2], [0, -per_mm, tile.shape[0] / 2], [0, 0, 1.0]])
    height, width = shot.ground.shape
    to_picture = np.linalg.inv(mm_to_px @ shot.to_ground)
    return warp(np.ascontiguousarray(tile, np.float32), to_picture, (width, height), beyond="tiles")


def _camera(light: NDArray[np.float32], look: Look, front: float, seed: int) -> NDArray[np.uint8]:
    """Exposure and the camera's faults on (H, W, channels) linear light."""
    optics = look.optics
    brightest = front * max(*look.material, *look.ground)
    signal = light * np.float32(EXPOSURE / brightest)
    for kernel in (disc(optics.defocus_px), _smear(optics.motion_px, optics.motion_deg)):
        if kernel is not None:
            signal = cv2.filter2D(signal, -1, kernel, borderType=cv2.BORDER_REPLICATE).reshape(signal.shape)
    if optics.noise > 0:
        shot_noise = np.sqrt(np.maximum(signal, np.float32(DARKEST)))
        shot_noise *= np.float32(optics.noise)
        shot_noise *= _grain(signal.shape, seed)
        signal += shot_noise
    signal *= np.float32(LEVELS)
    levels = np.clip(signal, 0, LEVELS, out=signal).astype(np.uint16)
    return _compress(_curve(optics.gamma)[levels], optics)


@lru_cache(maxsize=4)
def _curve(gamma: float) -> NDArray[np.uint8]:
    """8-bit code of every level of the sensor."""
    return (255 * (np.arange(LEVELS + 1) / LEVELS) ** (1 / gamma) + 0.5).astype(np.uint8)


def _grain(shape: tuple[int, ...], seed: int) -> NDArray[np.float32]:
    """Noise of mean 0 and deviation 1: heads in 64 tosses of a coin, near enough to normal, and quick."""
    tosses = np.random.default_rng(seed).integers(0, 2**64, shape, np.uint64)
    return (np.bitwise_count(tosses).astype(np.float32) - np.float32(32)) * np.float32(0.25)


def disc(diameter_px: float) -> NDArray[np.float32] | None:
    """Uniform disc of a given diameter, sampled eight times finer than the pixels."""
    if diameter_px <= 0:
        return None
    fine, reach = 8, int(np.ceil(diameter_px / 2))
    axis = (np.arange(fine * (2 * reach + 1)) + 0.5) / fine - reach - 0.5
    inside = (axis[:, None] ** 2 + axis**2 <= (diameter_px / 2) ** 2).astype(np.float32)
    side = 2 * reach + 1
    kernel = inside.reshape(side, fine, side, fine).sum(axis=(1, 3))
    return kernel / kernel.sum()


def _smear(length_px: float, angle_deg: float) -> NDArray[np.float32] | None:
    """Straight line of a given length through the kernel's centre."""
    if length_px <= 0:
        return None
    reach = int(np.ceil(length_px / 2)) + 1
    kernel = np.zeros((2 * reach + 1, 2 * reach + 1), np.float32)
    direction = np.array([np.cos(np.radians(angle_deg)), -np.sin(np.radians(angle_deg))])
    for step in np.linspace(-length_px / 2, length_px / 2, 16 * reach):
        x, y = step * direction + reach
        column, row = int(np.floor(x)), int(np.floor(y))
        for dr, dc in ((0, 0), (0, 1), (1, 0), (1, 1)):
            kernel[row + dr, column + dc] += (1 - abs(x - column - dc)) * (1 - abs(y - row - dr))
    return kernel / kernel.sum()


def _compress(picture: NDArray[np.uint8], optics: Optics) -> NDArray[np.uint8]:
    if optics.jpeg_quality is None:
        return picture
    _, data = cv2.imencode(".jpg", picture[..., ::-1].copy(), [cv2.IMWRITE_JPEG_QUALITY, optics.jpeg_quality])
    flag = cv2.IMREAD_COLOR if picture.shape[2] == 3 else cv2.IMREAD_GRAYSCALE
    return np.asarray(cv2.imdecode(data, flag), np.uint8).reshape(picture.shape)[..., ::-1]
