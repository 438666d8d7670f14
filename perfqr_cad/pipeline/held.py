"""Whether the part holds what was asked for by name, and a change with which it does: one that was made."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from perfqr_cad.errors import DesignError, NotHeldError, PerfQRError, UnreadError, WeakError
from perfqr_cad.pipeline.holding import front
from perfqr_cad.pipeline.request import SETTINGS, Request
from perfqr_cad.pipeline.resolve import asked_loads
from perfqr_cad.remedy import Remedy, Tried

if TYPE_CHECKING:
    from perfqr_cad.scan import ScanReport
    from perfqr_cad.structure import Reinforcement

LEAST_READERS = 2  # a part that fewer engines read from straight above counts as unread
LARGER, THICKER, THINNER = (1.25, 1.6), (1.5, 2.0), (0.75, 0.5)  # factors tried, the smallest change first
MOST_HOLDS = 3  # of the finder rings that are tried, the strongest ones
GRADED_MM = (75.0, 100.0)  # in large modules a verifier hardly sees bars of one line
ACCEPT_WEAK, ACCEPT_UNREAD = Remedy(accept_weak=True), Remedy(accept_unread=True)
BARS = ("bars", "bar_height_mm", "bar_width_mm")  # settings of recessed bars
THINNEST_MM = 0.8  # that still prints as a plate


def require_known(request: Request) -> None:
    """Raises `DesignError` for a decoder asked for by name that this machine does not have."""
    from perfqr_cad.scan.decoding.decoders import available

    for name in required(request):
        if name not in available():
            raise DesignError(f"decoder {name!r} is not here: require one of {', '.join(available())}")


def required(request: Request) -> tuple[str, ...]:
    """The decoders that must read the part, by name."""
    return tuple(name.strip() for name in (request.require or "").split(",") if name.strip())


def require_borne(request: Request, reinforced: Reinforcement) -> None:
    """Raises `WeakError` when a load was asked for by name and the part does not bear it."""
    named = {entry.partition("=")[0].strip() for entry in asked_loads(request)}
    if request.pressure_mpa:
        named.add("pressure")
    if "handling" in named:
        named |= {one.load.name for one in reinforced.capacities}
    short = [one for one in reinforced.capacities if one.load.name in named and not one.enough]
    if short and not request.accept_weak:
        raise WeakError(
            f"weak: bears {short[0].words}, asked {short[0].asked_n:.3g} N, and breaks {short[0].breaks} "
            f"({ACCEPT_WEAK} writes it all the same)"
        )


def require_read(request: Request, report: ScanReport) -> None:
    """Raises `UnreadError` when fewer than two engines read the part, or not those, or not to the tilt, that
    were asked for."""
    if (shortfall := _unread(request, report)) and not request.accept_unread:
        raise UnreadError(f"{shortfall} ({ACCEPT_UNREAD} writes it all the same)")


def _unread(request: Request, report: ScanReport) -> str | None:
    return _unread_by_decoders(request, report) or _below_grade(request, report)


def _below_grade(request: Request, report: ScanReport) -> str | None:
    """What the part lacks of the grade that was asked for."""
    from perfqr_cad.scan.grade import LETTERS

    if request.grade is None or report.grade is None:
        return None
    found = report.grade.counted
    if found.overall >= LETTERS[request.grade]:
        return None
    return (
        f"grade {found.overall:.1f} ({found.letter}) before {report.grade.ground}, limited by "
        f"{found.limiting}, asked for {LETTERS[request.grade]:.1f} ({request.grade})"
    )


def _unread_by_decoders(request: Request, report: ScanReport) -> str | None:
    readers, wanted = report.readers, required(request)
    if missing := [name for name in wanted if name not in readers]:
        return f"{', '.join(missing)}: required, and cannot read the part from straight above"
    if len(readers) < LEAST_READERS:
        read = f"{readers[0]} alone" if readers else "none"
        return f"{read} of {len(report.decoders)} decoders ({', '.join(report.decoders)}) reads the part"
    if (tilt_deg := request.scan_tilt_deg) is None:
        return None
    reach_deg = {name: report.decoders[name].max_tilt_deg or 0.0 for name in readers}
    there = [name for name, limit_deg in reach_deg.items() if limit_deg >= tilt_deg]
    if len(there) >= LEAST_READERS and set(wanted) <= set(there):
        return None
    limits = ", ".join(f"{name} to {limit_deg:g}°" for name, limit_deg in reach_deg.items())
    return f"read by {limits}, asked for {tilt_deg:g}°"


def advised(
    shortfall: NotHeldError, request: Request, make: Callable[[Request], object], *, plate: bool = True
) -> NotHeldError:
    """The shortfall with a remedy: the first change of the request with which `make` succeeds.

    plate   whether the request's thickness is that of the part
    """
    tried: list[Remedy] = []
    helping = _stronger if isinstance(shortfall, WeakError) else _more_legible
    for remedy in helping(request, plate):
        try:
            make(changed(request, remedy))
        except PerfQRError:
            tried.append(remedy)
        else:
            return type(shortfall)(str(shortfall), Tried(**remedy.changes))
    return type(shortfall)(f"{shortfall}: tried without success: {'; '.join(map(str, tried))}")


def changed(request: Request, remedy: Remedy) -> Request:
    """The request with the remedy's values, or the defaults of settings that it leaves out."""
    defaults = {declared.field: declared.default for declared in SETTINGS}
    values = {name: defaults[name] if value is None else value for name, value in remedy.changes.items()}
    return replace(request, **values)


def _stronger(request: Request, plate: bool) -> Iterator[Remedy]:
    """Changes that may bear more."""
    for hold in tuple(front(request.thickness_mm, request.nozzle_mm))[-MOST_HOLDS:]:
        if request.finder == "recessed" and (plate or hold.thickness_mm == request.thickness_mm):
            bars: dict[str, Any] = {"bars": hold.bars, "bar_height_mm": hold.height_mm}
            bars |= {} if hold.width_mm is None else {"bar_width_mm": hold.width_mm}
            yield Remedy(**bars, **({"thickness_mm": hold.thickness_mm} if plate else {}))
    # Flush bars are as high as the plate is thick, and have no settings of their own.
    flush: dict[str, Any] = {name: None for name in BARS if getattr(request, name) is not None}
    for factor in THICKER if plate else (1.0,):
        thick_mm = round(factor * request.thickness_mm, 2)
        yield Remedy(finder="panel", **({"thickness_mm": thick_mm} if plate else {}), **flush)


def _more_legible(request: Request, plate: bool) -> Iterator[Remedy]:
    """Single changes that may be read better."""
    if own := [name for name in ("colour", "ground") if getattr(request, name) is not None]:
        yield Remedy(**dict.fromkeys(own))
    if request.grade is not None and request.ground is None and request.backing_mm is None:
        yield Remedy(ground="black")  # if that is what will be behind it
    if request.depth_mm is not None:
        yield Remedy(depth_mm=None)
    for share in THINNER if plate else ():
        if (thin_mm := round(share * request.thickness_mm, 2)) >= THINNEST_MM:
            yield Remedy(thickness_mm=thin_mm)
    if request.size_mm is not None:
        for factor in LARGER:
            yield Remedy(size_mm=float(round(factor * request.size_mm)))
    elif request.grade is not None:
        for size_mm in GRADED_MM:
            yield Remedy(size_mm=size_mm)
