"""Plain sentences about what limits a part, from the report alone."""

from __future__ import annotations

from perfqr_cad.scan.report import DecoderResult, ScanReport

CLOSE_DEG = 5.0  # a part this near to the flat print's own limit is as good as it gets


def sentences(report: ScanReport) -> tuple[str, ...]:
    """What each decoder lacks against the flat print, and what helps. Empty when nothing does."""
    found = [_one(result) for result in report.decoders.values()]
    lines = [line for line in found if line]
    walls = [r.name for r in report.decoders.values() if r.frontal and _short_of_flat(r)]
    if walls:
        lines.append(
            "walls hide holes from the side: a 0.2 mm lip and 12 to 15° of draft behind it, or a thin plate, "
            "brings the tilt limit up"
        )
    if "zxing-cpp" in walls:
        lines.append(
            "zxing-cpp follows the dark ring of the lower-left finder: take recessed bars and a thicker "
            "plate, whose slot is deeper, or blacken the bar across it, until it gets less than a third of "
            "the light on the front"
        )
    return tuple(lines)


def _one(result: DecoderResult) -> str | None:
    if result.flat_frontal is False:
        return f"{result.name} does not read the flat print of this code either"
    if not result.frontal:
        return f"{result.name} does not read the part from straight above"
    if _short_of_flat(result):
        return (
            f"{result.name} reads the part from all sides to {result.max_tilt_deg or 0:g}°, "
            f"the flat print to {result.flat_max_tilt_deg:g}°"
        )
    return None


def _short_of_flat(result: DecoderResult) -> bool:
    if result.flat_max_tilt_deg is None:
        return False
    return (result.max_tilt_deg or 0.0) < result.flat_max_tilt_deg - CLOSE_DEG
