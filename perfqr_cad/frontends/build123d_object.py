"""`PerforatedQR`: the code as a build123d object, in builder and in algebra mode."""

from __future__ import annotations

from typing import Any

from build123d import Align, BasePartObject, BuildPart, Mode, RotationLike
from build123d.build_common import validate_inputs
from build123d.build_enums import Align as _Align

from perfqr_cad.frontends.designs import design_of
from perfqr_cad.solid.kernel.convert import to_build123d

CENTRED = (Align.CENTER, Align.CENTER, Align.MIN)


class PerforatedQR(BasePartObject):
    """A flat perforated code.

    text, size_mm, thickness_mm and all further settings are those of `perfqr_cad.make`; `rotation`, `align`
    and `mode` are build123d's. The code reads from +z; by default its back lies on the plane. `design` is
    the whole design, with its certificate.
    """

    _applies_to = [BuildPart._tag]  # pyright: ignore[reportPrivateUsage]  # noqa: RUF012 - build123d's own declaration

    def __init__(
        self,
        text: str,
        size_mm: float | None = None,
        thickness_mm: float = 1.6,
        *,
        rotation: RotationLike = (0, 0, 0),
        align: _Align | tuple[_Align, _Align, _Align] | None = CENTRED,
        mode: Mode = Mode.ADD,
        **settings: Any,
    ) -> None:
        context: BuildPart | None = BuildPart._get_context(self)  # pyright: ignore[reportPrivateUsage] - no public way
        validate_inputs(context, self)
        self.text = text
        self.thickness_mm = thickness_mm
        self.design = design_of(text, size_mm=size_mm, thickness_mm=thickness_mm, **settings)
        made = to_build123d(self.design.solid)
        self.size_mm = made.bounding_box().size.X
        super().__init__(part=made, rotation=rotation, align=align, mode=mode)
