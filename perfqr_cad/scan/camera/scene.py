"""A part ready to be filmed: built once, photographed from many sides and in many lights."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.scan.camera import layers, photo, raster, rays, skylight
from perfqr_cad.scan.camera.camera import Camera, View
from perfqr_cad.scan.camera.layers import Shot
from perfqr_cad.scan.camera.look import Light, Look
from perfqr_cad.scan.camera.phone import PhoneBody
from perfqr_cad.scan.camera.placing import FilmedPart
from perfqr_cad.scan.camera.stack import MARGIN, Stack, cut_stack

STEEPEST_DEG = 65.0  # no decoder reads a flat print beyond 60° (paper, Fig. 14)
LEAST_WEB_MM = 0.4  # one line of the common nozzle: nothing thinner is printed
SECTION_PX = 800  # sections as fine as a 1000-pixel view that the part fills to 80 %
WEB_PX = 2  # no web of fewer pixels is seen
KEPT_SHOTS = 4  # views whose light is kept: the grounds differ in colour only, 12 bytes a pixel each
KEPT_SHADOWS = 12  # lights with a phone's shadow, 5 MB each
SHADOW_DEG = 7.5  # views that differ by less have the same shadow
GROUND_STEP = 0.2  # of the reflectance with which grounds send light back
TARGET_PX = 450  # a code seen smaller than this is rendered larger and averaged down


@dataclass(frozen=True)
class Scene:
    """A part before the camera; light and sections are worked out on first use and kept.

    sections   those of a plate, where they are known without its mesh
    """

    part: FilmedPart
    least_web_mm: float = LEAST_WEB_MM
    sections: Stack | None = None

    def prepare(self, look: Look) -> None:
        """Work out sections and light now, before several threads ask for pictures."""
        if self.part.flat:
            self._plate_light(look, _reflectance(look))
        else:
            _ = self._tracer

    def photo(self, view: View, look: Look | None = None, *, seed: int = 0) -> NDArray[np.uint8]:
        """What the camera delivers: gray (H, W) uint8, the same for the same seed."""
        look = look or Look()
        return photo.develop(self.shot(view, look), look, front=look.light.on_front, seed=seed)

    def photo_colour(self, view: View, look: Look | None = None, *, seed: int = 0) -> NDArray[np.uint8]:
        """The same in colour (H, W, 3), red first."""
        look = look or Look()
        return photo.develop_colour(self.shot(view, look), look, front=look.light.on_front, seed=seed)

    def shot(self, view: View, look: Look) -> Shot:
        """Light on the picture before colours and camera faults; the last few are kept."""
        key = view, look.light, look.gap_mm, _reflectance(look), _ground_reflectance(look), look.phone
        kept = self._shots.get(key)
        if kept is None:
            kept = self._shots[key] = self._shot(view, look)
            while len(self._shots) > KEPT_SHOTS:
                self._shots.pop(next(iter(self._shots)), None)
        return kept

    def _shot(self, view: View, look: Look) -> Shot:
        finer = int(np.clip(np.ceil(TARGET_PX / (view.fill * view.size_px)), 1, 4))
        camera = Camera(replace(view, size_px=view.size_px * finer), self.part.code)
        reflectance = _reflectance(look)
        if self.part.flat:
            shot = self.layered(camera, look, reflectance)
        else:
            shot = self.cast(camera, look, reflectance)
        return shot if finer == 1 else _smaller(shot, finer)

    def layered(self, camera: Camera, look: Look, reflectance: float) -> Shot:
        """The view of a plate by its sections."""
        return layers.shoot(
            self._stack,
            self._brightness(camera, look, reflectance),
            camera,
            gap_mm=look.gap_mm,
            least_web_mm=self._visible_web_mm,
        )

    def _brightness(self, camera: Camera, look: Look, reflectance: float) -> skylight.Brightness:
        """The light of a view: with the phone's shadow, the same for views that are nearly the same."""
        light = self._plate_light(look, reflectance)
        view = camera.view
        turned = round(view.azimuth_deg / SHADOW_DEG) if view.tilt_deg > SHADOW_DEG else 0
        key = id(light), look.phone, round(view.tilt_deg / SHADOW_DEG), turned, view.distance
        kept = self._seen.get(key)
        if kept is None:
            hidden = PhoneBody.of(camera).shares(skylight.towards(look.light)) if look.phone else None
            kept = self._seen[key] = light.seen(hidden)
            while len(self._seen) > KEPT_SHADOWS:
                self._seen.pop(next(iter(self._seen)), None)
        return kept

    def _plate_light(self, look: Look, reflectance: float) -> skylight.PlateLight:
        ground = _ground_reflectance(look)
        key = look.light, look.gap_mm, reflectance, ground
        if key not in self._lit:
            first = look.light, look.gap_mm
            if first not in self._first_light:
                self._first_light[first] = skylight.first_light(self._stack, look.light, gap_mm=look.gap_mm)
            self._lit[key] = skylight.plate_light(
                self._stack,
                look.light,
                self._first_light[first],
                gap_mm=look.gap_mm,
                reflectance=reflectance,
                ground=ground,
            )
        return self._lit[key]

    def cast(self, camera: Camera, look: Look, reflectance: float) -> Shot:
        """The view by ray casting, which any mesh allows; the samples depend on the view only."""
        return rays.shoot(
            self._tracer,
            camera,
            look.light,
            gap_mm=look.gap_mm,
            reflectance=(reflectance, _ground_reflectance(look)),
            phone=look.phone,
            seed=camera.view.size_px,
        )

    @cached_property
    def _lit(self) -> dict[tuple[Light, float, float, float], skylight.PlateLight]:
        return {}

    @cached_property
    def _seen(self) -> dict[tuple[int, bool, int, int, float], skylight.Brightness]:
        return {}

    @cached_property
    def _first_light(self) -> dict[tuple[Light, float], skylight.FirstLight]:
        return {}

    @cached_property
    def _shots(self) -> dict[tuple[View, Light, float, float, float, bool], Shot]:
        return {}

    @cached_property
    def _tracer(self) -> rays.Tracer:
        return rays.tracer(self.part)

    @property
    def _visible_web_mm(self) -> float:
        """The least web, or what a few pixels show of a part that is much larger than any print."""
        return max(self.least_web_mm, WEB_PX * self.part.code.edge_mm / SECTION_PX)

    @cached_property
    def _stack(self) -> Stack:
        if self.sections is not None:
            return self.sections
        vertices = self.part.in_frame()
        thickness = float(np.ptp(vertices[:, 2]))
        return cut_stack(
            vertices,
            self.part.faces,
            edge_mm=MARGIN * 2 * float(np.abs(vertices[:, :2]).max()),
            layers=layers.layers_needed(thickness, STEEPEST_DEG, self._visible_web_mm),
            pixels=SECTION_PX,
        )


def _reflectance(look: Look) -> float:
    """The material's reflectance for light that bounces in the holes, as one number."""
    return round(float(np.dot(photo.LUMA, look.material)), 2)


def _ground_reflectance(look: Look) -> float:
    """The ground's, for light that it sends up into the holes: in steps, so that like grounds share their
    light."""
    return round(float(np.dot(photo.LUMA, look.ground)) / GROUND_STEP) * GROUND_STEP


def _smaller(shot: Shot, factor: int) -> Shot:
    """The shot at a resolution `factor` times lower, by area."""
    size = (shot.cover.shape[1] // factor, shot.cover.shape[0] // factor)
    material, ground, cover = (raster.shrunk(p, size) for p in (shot.material, shot.ground, shot.cover))
    return Shot(material, ground, cover, shot.to_ground @ raster.zoom(factor))


def jittered(view: View, rng: np.random.Generator) -> View:
    """The same view by a hand that is not quite still: a degree, a few degrees of roll, a few percent."""
    return replace(
        view,
        tilt_deg=float(np.clip(view.tilt_deg + rng.uniform(-1, 1), 0, 89)),
        azimuth_deg=view.azimuth_deg + float(rng.uniform(-3, 3)),
        roll_deg=view.roll_deg + float(rng.uniform(-4, 4)),
        fill=view.fill * float(rng.uniform(0.92, 1.05)),
    )
