"""The certificate: what was measured on a design, as plain values. Null where a link gave none."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

from perfqr_cad import __version__
from perfqr_cad.export.colour_change import colour_changes
from perfqr_cad.export.design_view import DesignView

if TYPE_CHECKING:
    from perfqr_cad.capture import Capture
    from perfqr_cad.export import FileRecord
    from perfqr_cad.pattern.choice import Chosen
    from perfqr_cad.pipeline.promises import Promise
    from perfqr_cad.pipeline.request import Request
    from perfqr_cad.pipeline.source import Source
    from perfqr_cad.scan import ScanReport
    from perfqr_cad.structure import Capacity, Reinforcement, SolidCheck, StressField
    from perfqr_cad.symbol import Symbol


class Finished(DesignView, Protocol):
    """What the certificate reads of a design: what exporters may read, and how it came to be."""

    @property
    def request(self) -> Request: ...

    @property
    def symbol(self) -> Symbol: ...

    @property
    def source(self) -> Source: ...

    @property
    def stress(self) -> StressField: ...

    @property
    def reinforcement(self) -> Reinforcement: ...

    @property
    def verified(self) -> SolidCheck | None: ...

    @property
    def scan(self) -> ScanReport: ...

    @property
    def promises(self) -> Sequence[Promise]: ...

    @property
    def mass_g(self) -> float: ...

    @property
    def files(self) -> Sequence[FileRecord]: ...

    @property
    def timings_s(self) -> Mapping[str, float]: ...


def certificate(design: Finished) -> dict[str, Any]:
    """All sections, in the order of the chain."""
    return {
        "payload": payload_text(design),
        "symbol": _symbol(design),
        "readability": _readability(design),
        "connectivity": _connectivity(design),
        "structure": _structure(design),
        "solid": _solid(design),
        "scan": design.scan.as_dict(),
        "promises": [promise.as_dict() for promise in design.promises],
        "files": [record.as_dict() for record in design.files],
        "timings_s": {step: round(seconds, 4) for step, seconds in design.timings_s.items()},
        "request": design.request.as_dict(),
        "version": __version__,
    }


def summary(design: Finished) -> str:
    """A few lines for people."""
    pattern, stress, solid = design.pattern, design.stress, design.solid
    size = " × ".join(f"{high - low:.1f}" for low, high in zip(*solid.bbox_mm, strict=True))
    limits = {name: design.scan.decoders[name].max_tilt_deg for name in design.scan.readers}
    readers = ", ".join(f"{name} to {tilt_deg:g}°" for name, tilt_deg in limits.items())
    bridges, lost = len(pattern.bridges), sum(pattern.readability.errors)
    in_3d: list[str] = []
    if (checked := design.verified) is not None:
        in_3d.append(
            f"in 3-D    {checked.solid_stress_mpa:.3g} MPa, deflection {checked.solid_deflection_mm:.3g} mm, "
            "the walls taken as upright"
        )
    weak = [f"WEAK      {design.reinforcement.status.removeprefix('weak: ')}"]
    lines = [
        *([] if design.reinforcement.strong else weak),
        *(f"bears     {one.words}, asked {one.asked_n:.2g} N" for one in design.reinforcement.capacities),
        f"payload   {payload_text(design)}",
        f"symbol    version {design.symbol.version}-{design.symbol.level}, mask {design.symbol.mask}, "
        f"L(Q) = {pattern.readability.total:.4g}",
        *chosen_words(design.source.choice),
        f"pattern   module {pattern.module_mm:.3f} mm, {pattern.islands_before} islands, {bridges} bridges, "
        f"{lost} codewords lost",
        f"strength  {stress.max_stress_mpa:.3g} MPa of {stress.limit_mpa:.3g} allowed, "
        f"deflection {stress.max_deflection_mm:.3g} mm, {stress.material}, {design.mass_g:.1f} g",
        *in_3d,
        f"solid     {size} mm, {solid.volume_mm3:.1f} mm³, {solid.faces} faces, "
        f"{'valid' if solid.valid else 'NOT VALID'}",
        f"scan      read by {readers}",
    ]
    lines += [f"grounds   {design.scan.ground_words}"] if design.scan.grounds else []
    if (likeness := design.scan.likeness) is not None:
        lines += [f"art       {likeness.words(design.scan.readers)}"]
    lines += [] if design.scan.grade is None else [f"grade     {design.scan.grade.words}"]
    lines += [f"note      {note}" for note in (*solid.notes, *stress.warnings, *design.scan.warnings)]
    for record in design.files:
        lines.append(f"wrote     {record.path} ({record.bytes:,} bytes)")
        lines += [f"          {record.remarks}"] if record.remarks else []
    return "\n".join(lines)


def chosen_words(choice: Chosen | None) -> list[str]:
    """Why the symbol is not the one that an ordinary encoder draws; nothing where it is."""
    if choice is None or choice.symbol == choice.plain:
        return []
    ordinary = f"{choice.plain.version}-{choice.plain.level}, mask {choice.plain.mask}"
    corners = f"{len(choice.left.corners)} corners to be joined instead of {len(choice.left_plain.corners)}"
    pads = ", by the bits after its end" if choice.pads_are_free else ""
    return [f"chosen    rather than version {ordinary}: {corners}{pads}"]


def payload_text(design: Finished) -> str | None:
    """The payload as text; None for bytes in no known encoding."""
    from perfqr_cad.symbol import payload_of

    return payload_of(design.symbol).text


def reading(capture: Capture) -> dict[str, Any]:
    """What a picture says, and how damaged it is: errors per block and L(Q), Eqs. (1)-(3)."""
    from perfqr_cad.symbol import readability

    recovery = capture.recovery
    found = readability(recovery.observed, recovery.symbol)
    payload = recovery.payload
    return {
        "payload": payload.text,
        "data_hex": None if payload.text is not None else payload.data.hex(),
        "version": recovery.symbol.version,
        "level": recovery.symbol.level,
        "mask": recovery.symbol.mask,
        "blocks": [
            {"errors": errors, "capacity": capacity, "erasures": erasures}
            for errors, capacity, erasures in zip(
                recovery.errors, recovery.capacity, recovery.erasures, strict=True
            )
        ],
        "format_regions_damaged": found.format_regions_damaged,
        "loss": found.total,
        "unused_correction": found.unused_correction,
        "art": capture.art.kind,
        "submodules": capture.art.scale,
        "inverted": capture.inverted,
        "found_by": capture.engine,
    }


def _symbol(design: Finished) -> dict[str, Any]:
    symbol = design.symbol
    return {
        "version": symbol.version,
        "level": symbol.level,
        "mask": symbol.mask,
        "modules": symbol.size,
        "choice": None if design.source.choice is None else _choice(design.source.choice),
    }


def _choice(choice: Chosen) -> dict[str, Any]:
    """What was chosen so that less must be joined, beside the symbol of an ordinary encoder."""
    from perfqr_cad.symbol import payload_of

    return {
        "standard_padding": not choice.pads_are_free,
        "segments": [segment.mode for segment in payload_of(choice.symbol).segments],
        "corners": len(choice.left.corners),
        "pieces": choice.left.count,
        "ordinary": {
            "version": choice.plain.version,
            "mask": choice.plain.mask,
            "corners": len(choice.left_plain.corners),
            "pieces": choice.left_plain.count,
        },
    }


def _readability(design: Finished) -> dict[str, Any]:
    found = design.pattern.readability
    return {
        "loss": found.total,
        "blocks": [
            {"errors": errors, "capacity": capacity}
            for errors, capacity in zip(found.errors, found.capacity, strict=True)
        ],
        "format_regions_damaged": found.format_regions_damaged,
        "unused_correction": found.unused_correction,
    }


def _connectivity(design: Finished) -> dict[str, Any]:
    pattern = design.pattern
    return {
        "islands_before": pattern.islands_before,
        "components": design.solid.triangles.body_count,
        "bridges": [
            {"stage": b.stage, "start_mm": list(b.start), "end_mm": list(b.end), "width_mm": b.width_mm}
            for b in pattern.bridges
        ],
        "area_mm2": pattern.region.area,
        "min_web_mm": pattern.spec.web_mm,
        "changed_area_mm2": pattern.changed_area_mm2,
        "edits": dict(pattern.edits),
        "optimality": None if pattern.optimality is None else pattern.optimality._asdict(),
    }


def _structure(design: Finished) -> dict[str, Any]:
    stress, loop = design.stress, design.reinforcement
    return {
        "bears": [_capacity(one) for one in loop.capacities],
        "material": stress.material,
        "e_mpa": stress.e_mpa,
        "nu": stress.nu,
        "shear_correction": stress.kappa,
        "disc_width_mm": stress.disc_width_mm,
        "support": stress.support,
        "load_n": list(stress.load_n),
        "reactions_n": list(stress.reactions_n),
        "balance": stress.balance,
        "max_stress_mpa": stress.max_stress_mpa,
        "max_stress_at_mm": list(stress.max_stress_at_mm),
        "sharp_peak_mpa": stress.sharp_peak_mpa,
        "yield_mpa": stress.yield_mpa,
        "limit_mpa": stress.limit_mpa,
        "safety_factor": stress.safety_factor,
        "max_deflection_mm": stress.max_deflection_mm,
        "max_deflection_at_mm": list(stress.max_deflection_at_mm),
        "mass_g": design.mass_g,
        "iterations": loop.iterations,
        "status": loop.status,
        "remedies": list(loop.remedies),
        "solver": stress.solver,
        "warnings": list(stress.warnings),
        "solid_check": None if design.verified is None else _solid_check(design.verified),
    }


def _capacity(one: Capacity) -> dict[str, Any]:
    """What the part bears of one load, where, and what is allowed."""
    return {
        "load": one.load.name,
        "bears_n": one.bears_n,
        "asked_n": one.asked_n,
        "enough": one.enough,
        "pressed": one.where,
        "pressed_at_mm": None if one.loaded_at_mm is None else list(one.loaded_at_mm),
        "breaks": one.breaks,
        "breaks_at_mm": list(one.stressed_at_mm),
        "stress_mpa": one.stress_mpa,
        "limit_mpa": one.limit_mpa,
        "deflection_mm": one.deflection_mm,
    }


def _solid_check(found: SolidCheck) -> dict[str, Any]:
    """The shell beside the same part in three dimensions, on one mesh."""
    return {
        "max_deflection_mm": found.solid_deflection_mm,
        "max_stress_mpa": found.solid_stress_mpa,
        "shell_over_solid_deflection": found.deflection_ratio,
        "shell_over_solid_stress": found.stress_ratio,
        "unknowns": found.unknowns,
        "solver": found.solver,
    }


def _solid(design: Finished) -> dict[str, Any]:
    solid = design.solid
    changes = colour_changes(solid) if design.request.colour_change else ()
    return {
        "valid": solid.valid,
        "solids": solid.solids,
        "faces": solid.faces,
        "volume_mm3": solid.volume_mm3,
        "bbox_mm": [list(corner) for corner in solid.bbox_mm],
        "module_mm": design.pattern.module_mm,
        "notes": list(solid.notes),
        "colour_changes": [change.as_dict() for change in changes],
    }
