"""Pictures of codes by third-party generators, and what cameras and printers do to them; all from a seed."""

from __future__ import annotations

import contextlib
import io
import random
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import cv2
import numpy as np
import qrcode
import segno
from numpy.typing import NDArray
from PIL import Image
from pyqart import QArtist, QrData, QrHalftonePrinter, QrImagePrinter, QrPainter
from pyqart.art.source import QArtSourceImage
from qrcode.image.styledpil import StyledPilImage
from qrcode.image.styles.moduledrawers import pil as drawers
from qrtsy import DitherCellSize, DitherMode, ImageMode, RenderOptions
from qrtsy.integrations.segno import render_qr

Picture = NDArray[np.uint8]

LEVELS = ("L", "M", "Q", "H")


@dataclass(frozen=True, eq=False)
class Sample:
    """A picture and the bytes that its code holds (pyqart appends digits of its own: `exact` is False)."""

    name: str
    picture: Picture
    payload: bytes
    exact: bool = True

    def is_right(self, data: bytes) -> bool:
        return data == self.payload if self.exact else data.startswith(self.payload)


def photo(seed: int, side: int = 240) -> Image.Image:
    """A colour picture with soft shapes, edges and texture."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:side, :side] / side
    picture = rng.uniform(60, 200, 3) + np.outer(y.ravel(), rng.uniform(-90, 90, 3)).reshape(side, side, 3)
    for _ in range(int(rng.integers(3, 9))):
        centre, radius = rng.uniform(0, 1, 2), rng.uniform(0.08, 0.4)
        ring = np.hypot(x - centre[0], (y - centre[1]) * rng.uniform(0.6, 1.6))
        cover = 1 / (1 + np.exp((ring - radius) / rng.choice([0.005, 0.05])))
        picture += cover[..., None] * (rng.uniform(0, 255, 3) - picture)
    picture += cv2.GaussianBlur(rng.normal(0, 60, (side, side)), (0, 0), 2)[..., None]
    return Image.fromarray(np.clip(picture, 0, 255).astype(np.uint8))


def text(seed: int, length: int = 30) -> str:
    rng = np.random.default_rng(seed + 7)
    return "https://example.org/" + "".join(rng.choice(list("abcdefghijkmnpqrstuvwxyz0123456789-/"), length))


def plain(seed: int, version: int | None = None, level: str = "M", scale: int = 4, border: int = 4) -> Sample:
    """Black squares on white by segno."""
    content = text(seed, 6 if version is None or version < 6 else 8 * version)
    content = content[-10:] if version == 1 else content
    code = segno.make(content, version=version, error=level, micro=False, boost_error=False)
    squares = np.kron(np.pad(np.array(code.matrix), border), np.ones((scale, scale)))
    return Sample(
        f"plain v{code.designator}", np.where(squares > 0, 0, 255).astype(np.uint8), content.encode()
    )


def halftone(seed: int, module_px: int = 3) -> Sample:
    """3 × 3 dithered halftone by QRtsy."""
    options = RenderOptions(
        module_size=module_px,
        core_size=module_px // 3,
        image_mode=ImageMode.MONOCHROME,
        dither=DitherMode.FLOYD_STEINBERG,
        dither_cell_size=DitherCellSize.CORE,
    )
    return _qrtsy("halftone", seed, options)


def picture_dots(seed: int) -> Sample:
    """Colour picture under small data dots by QRtsy."""
    rng = np.random.default_rng(seed)
    size = int(rng.integers(6, 16))
    mode = list(ImageMode)[int(rng.integers(3))]
    options = RenderOptions(
        module_size=size,
        core_size=max(2, round(size * rng.uniform(0.3, 0.5))),
        image_mode=mode,
        module_tint=float(rng.uniform(0, 0.4)),
        shrink_timing_patterns=bool(rng.random() < 0.3),
        shrink_alignment_patterns=bool(rng.random() < 0.3),
        shrink_separators=bool(rng.random() < 0.3),
        border=int(rng.choice([0, 2, 4])),
    )
    return _qrtsy(f"picture dots {mode}", seed, options)


def _qrtsy(name: str, seed: int, options: RenderOptions) -> Sample:
    content = text(seed, 10 + seed % 30)
    code = segno.make(content, error=LEVELS[2 + seed % 2], micro=False)
    drawn = render_qr(code, photo(seed), options=options)
    return Sample(name, np.array(drawn.convert("RGB")), content.encode())


def qart(seed: int, version: int | None = None) -> Sample:
    """QArt by pyqart: the picture is drawn by the free digits of the message."""
    random.seed(seed)
    content = text(seed, 4)
    source = io.BytesIO()
    photo(seed, 120).save(source, "PNG")
    with contextlib.redirect_stdout(io.StringIO()):
        artist = QArtist(content, QArtSourceImage(source), version or 3 + seed % 3, dither=seed % 2 == 0)
        drawn = QrImagePrinter.print(artist, None, point_width=2 + seed % 6, border_width=(seed % 5) * 6)
    return Sample("qart", np.array(drawn.convert("RGB")), content.encode(), exact=False)


def qart_halftone(seed: int) -> Sample:
    """Colour or grey halftone by pyqart."""
    content = text(seed, 4)
    with tempfile.NamedTemporaryFile(suffix=".png") as source:
        photo(seed).save(source.name)
        drawn = QrHalftonePrinter.print(
            QrPainter(QrData(content, 3), None),
            point_width=3 + 3 * (seed % 3),
            border_width=8,
            img=source.name,
            colorful=seed % 2 == 0,
        )
    return Sample("halftone pyqart", np.array(drawn.convert("RGB")), content.encode())


def artistic(seed: int) -> Sample:
    """Picture behind small modules by segno's qrcode-artistic."""
    content = text(seed, 20)
    code = segno.make(content, error="H", micro=False)
    background, target = io.BytesIO(), io.BytesIO()
    photo(seed).save(background, "PNG")
    background.seek(0)
    code.to_artistic(background=background, target=target, kind="png", scale=4 + seed % 6, border=seed % 5)
    with Image.open(io.BytesIO(target.getvalue())) as drawn:
        return Sample("artistic", np.array(drawn.convert("RGB")), content.encode())


DRAWERS: tuple[Callable[[], object], ...] = (
    drawers.RoundedModuleDrawer,
    drawers.CircleModuleDrawer,
    drawers.GappedSquareModuleDrawer,
    drawers.VerticalBarsDrawer,
    drawers.HorizontalBarsDrawer,
)


def styled(seed: int) -> Sample:
    """Rounded modules, dots, bars, colours and a logo by qrcode[pil]."""
    rng = np.random.default_rng(seed)
    content = text(seed, 12 + seed % 20)
    code = qrcode.QRCode(
        error_correction=qrcode.constants.ERROR_CORRECT_H,
        border=int(rng.choice([1, 2, 4])),
        box_size=int(rng.integers(6, 14)),
    )
    code.add_data(content)
    drawer = DRAWERS[seed % len(DRAWERS)]
    logo = photo(seed) if rng.random() < 0.5 else None
    drawn = code.make_image(
        image_factory=StyledPilImage, module_drawer=drawer(), embedded_image=logo, embedded_image_ratio=0.2
    )
    picture = np.array(drawn.get_image().convert("RGB"))
    ink = rng.uniform(0, 120, 3)
    paper = 255 - rng.uniform(0, 60, 3)
    share = picture[..., :1] / 255.0 if logo is None else picture / 255.0
    tinted = np.clip(ink + (paper - ink) * share, 0, 255).astype(np.uint8)
    return Sample(f"styled {drawer.__name__}{' logo' if logo else ''}", tinted, content.encode())


def dots(seed: int, share: float = 0.7) -> Sample:
    """Every module, finders too, a round dot of `share` of a module."""
    content = text(seed, 20)
    code = np.array(segno.make(content, error="q", micro=False).matrix, dtype=bool)
    scale = 18
    at = (np.arange(scale) + 0.5) / scale - 0.5
    dot = np.hypot(*np.meshgrid(at, at)) < share / 2
    picture = np.where(np.kron(np.pad(code, 4), dot), 0, 255).astype(np.uint8)
    return Sample("dots", picture, content.encode())


def coloured(seed: int) -> Sample:
    """Dark and light are two dithered families of colours whose luminances overlap less than their hues."""
    rng = np.random.default_rng(seed)
    content = text(seed, 20)
    code = np.pad(np.array(segno.make(content, error="h", micro=False).matrix, dtype=bool), 4)
    scale = int(rng.integers(5, 10))
    dark = np.kron(code, np.ones((scale, scale), bool))
    noise = rng.uniform(-1, 1, (*dark.shape, 3))
    inks = np.where(
        dark[..., None], rng.uniform([0, 0, 90], [60, 70, 190]), rng.uniform([200, 120, 60], [255, 190, 160])
    )
    return Sample("dithered colour", np.clip(inks + 70 * noise, 0, 255).astype(np.uint8), content.encode())


def corpus(seed: int) -> Iterator[Sample]:
    """Twenty-three pictures of all kinds, artistic codes first."""
    version = (2, 5, 7, 10, 15, 25)[seed % 6]
    yield halftone(seed, (3, 6, 9, 12)[seed % 4])
    yield picture_dots(seed)
    yield picture_dots(seed + 500)
    yield qart(seed)
    yield qart_halftone(seed)
    yield artistic(seed)
    yield styled(seed)
    yield dots(seed, (0.9, 0.75, 0.6, 0.5)[seed % 4])
    yield coloured(seed)
    yield inverted(styled(seed + 30))
    yield mirrored(styled(seed + 31))
    yield scratched(styled(seed + 20), seed, (0.05, 0.1, 0.15)[seed % 3])
    yield rescaled(halftone(seed + 9, 12), (0.4, 0.6, 1.7)[seed % 3])
    yield degraded(halftone(seed + 90, 9), seed, (1.0, 2.0)[seed % 2], 20)
    yield tilted(styled(seed + 50), seed, (30, 45, 55, 60)[seed % 4])
    yield tilted(halftone(seed + 50, 12), seed, (20, 35, 45)[seed % 3])
    yield tilted(dots(seed), seed, (20, 40)[seed % 2])
    yield degraded(tilted(picture_dots(seed + 60), seed, 30), seed, 1.0, 10)
    yield tilted(plain(seed, (10, 20, 30, 40)[seed % 4], scale=6), seed, (20, 35, 45)[seed % 3], 1200)
    yield curved(plain(seed, version), (0.4, 0.5, 0.8)[seed % 3])
    yield degraded(plain(seed, 3, scale=5), seed, (2.0, 3.0, 3.5)[seed % 3], 15)
    yield inverted(plain(seed, 20))
    yield rescaled(plain(seed, 6, border=0, scale=6), (0.25, 0.35, 0.5)[seed % 3])


CORPUS_SIZE = 23
ARTISTIC_OF_CORPUS = 13  # the first ones

# What happens to pictures ---------------------------------------------------------------------------


def tilted(sample: Sample, seed: int, tilt_deg: float = 40.0, side: int = 700) -> Sample:
    """Seen obliquely by a camera, turned, on a cluttered ground, in uneven light."""
    rng = np.random.default_rng(seed)
    picture = _rgb(sample.picture)
    turn, lean = rng.uniform(0, 2 * np.pi), np.deg2rad(tilt_deg)
    axis = np.array([np.cos(turn), np.sin(turn), 0.0])
    rotation = cv2.Rodrigues(axis * lean)[0] @ cv2.Rodrigues(np.array([0, 0, rng.uniform(-np.pi, np.pi)]))[0]
    height, width = picture.shape[:2]
    corners = np.array([[-width, -height], [width, -height], [width, height], [-width, height]]) / max(
        width, height
    )
    space = np.pad(corners, ((0, 0), (0, 1))) @ rotation.T
    view = space[:, :2] / (space[:, 2:] + 4.0) * (4.0 * side * 0.36) + side / 2
    pixels = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32) - 0.5
    warp = cv2.getPerspectiveTransform(pixels, view.astype(np.float32))
    ground = np.array(photo(seed + 1, side))
    # Area averaging: a camera does not alias.
    big = cv2.warpPerspective(
        picture, np.diag([2, 2, 1.0]) @ warp, (2 * side, 2 * side), flags=cv2.INTER_LINEAR
    )
    cover = cv2.warpPerspective(
        np.full((height, width), 255, np.uint8), np.diag([2, 2, 1.0]) @ warp, (2 * side, 2 * side)
    )
    seen = cv2.resize(big, (side, side), interpolation=cv2.INTER_AREA).astype(float)
    share = cv2.resize(cover, (side, side), interpolation=cv2.INTER_AREA)[..., None] / 255.0
    mixed = seen * share + ground * (1 - share)
    return _named(sample, f"tilted {tilt_deg:g}°", lit(mixed, seed))


def curved(sample: Sample, bend: float = 0.8, side: int = 700) -> Sample:
    """Wrapped on a cylinder that spans `bend` radians to either side, upright axis, seen from nearby."""
    picture = _rgb(sample.picture)
    height, width = picture.shape[:2]
    y, x = (np.mgrid[:side, :side] + 0.5) / side * 2.2 - 1.1
    radius = 1.0 / bend
    distance = 5.0
    # Ray from (0, 0, distance) through the plane of the tangent point, met with the cylinder.
    a = x * x / distance**2 + 1
    b = -2 * (distance - (0.0 - radius) * 1.0)
    c = (distance + radius) ** 2 - radius**2
    a_, b_, c_ = a, b, c
    root = np.sqrt(np.maximum(b_ * b_ - 4 * a_ * c_, 0))
    depth = (-b_ - root) / (2 * a_)
    hit = b_ * b_ >= 4 * a_ * c_
    angle = np.arcsin(np.clip(x / distance * depth / radius, -1, 1))
    u, v = angle / bend, y / distance * depth
    inside = hit & (np.abs(u) <= 1) & (np.abs(v) <= 1)
    columns, rows = (
        ((u + 1) / 2 * width - 0.5).astype(np.float32),
        ((v + 1) / 2 * height - 0.5).astype(np.float32),
    )
    seen = cv2.remap(picture, columns, rows, cv2.INTER_LINEAR)
    return _named(sample, f"curved {bend:g}", np.where(inside[..., None], seen, 90).astype(np.uint8))


def degraded(
    sample: Sample, seed: int, blur_px: float = 1.0, noise: float = 10.0, quality: int = 60
) -> Sample:
    """Out of focus, noisy and compressed."""
    rng = np.random.default_rng(seed)
    soft = cv2.GaussianBlur(_rgb(sample.picture).astype(np.float32), (0, 0), blur_px)
    rough = np.clip(soft + rng.normal(0, noise, soft.shape), 0, 255).astype(np.uint8)
    packed = io.BytesIO()
    Image.fromarray(rough).save(packed, "JPEG", quality=quality)
    with Image.open(io.BytesIO(packed.getvalue())) as image:
        return _named(sample, f"blur {blur_px:g} noise {noise:g}", np.array(image))


def inverted(sample: Sample) -> Sample:
    return _named(sample, "inverted", 255 - sample.picture)


def mirrored(sample: Sample) -> Sample:
    return _named(sample, "mirrored", np.ascontiguousarray(sample.picture[:, ::-1]))


def rescaled(sample: Sample, factor: float) -> Sample:
    """Resized as a browser does."""
    height, width = sample.picture.shape[:2]
    size = (round(width * factor), round(height * factor))
    kind = cv2.INTER_AREA if factor < 1 else cv2.INTER_LINEAR
    return _named(sample, f"×{factor:g}", cv2.resize(sample.picture, size, interpolation=kind))


def scratched(sample: Sample, seed: int, share: float = 0.1) -> Sample:
    """Blots over part of the picture's area."""
    rng = np.random.default_rng(seed)
    picture = _rgb(sample.picture).copy()
    height, width = picture.shape[:2]
    covered = 0.0
    while covered < share:
        radius = rng.uniform(0.02, 0.08) * width
        at = (int(rng.uniform(0.3, 0.95) * width), int(rng.uniform(0.3, 0.95) * height))
        cv2.circle(picture, at, int(radius), tuple(int(c) for c in rng.integers(60, 200, 3)), -1)
        covered += np.pi * radius**2 / (height * width)
    return _named(sample, f"blots {share:g}", picture)


def lit(picture: NDArray[np.floating] | Picture, seed: int) -> Picture:
    """Light that falls off across the picture, and a soft shadow."""
    rng = np.random.default_rng(seed)
    height, width = picture.shape[:2]
    y, x = np.mgrid[:height, :width] / max(height, width)
    turn = rng.uniform(0, 2 * np.pi)
    light = 0.75 + 0.35 * (np.cos(turn) * (x - 0.5) + np.sin(turn) * (y - 0.5))
    edge = (x - rng.uniform(0.2, 0.8)) * np.cos(turn + 1) + (y - rng.uniform(0.2, 0.8)) * np.sin(turn + 1)
    light *= 1 - 0.4 / (1 + np.exp(-edge / 0.03))
    return np.clip(picture * light[..., None], 0, 255).astype(np.uint8)


def _rgb(picture: Picture) -> Picture:
    return picture if picture.ndim == 3 else np.repeat(picture[..., None], 3, axis=2)


def _named(sample: Sample, name: str, picture: Picture) -> Sample:
    return Sample(f"{sample.name}, {name}", picture, sample.payload, sample.exact)
