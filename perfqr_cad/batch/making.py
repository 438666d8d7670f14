"""One row made: what runs in a worker."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from perfqr_cad.batch.order import Order
from perfqr_cad.errors import NotHeldError, PerfQRError

Status = Literal["made", "kept", "not held", "refused", "failed"]


@dataclass(frozen=True)
class Outcome:
    """What became of a row.

    status   made now; kept from a run before; not held (weak or unread where it was asked not to be); refused
             for what it asks; failed, by a fault that is not the row's
    note     one line that says why it was not made
    weakest  the load of which the part bears the least share of what is asked, and how much, in words
    readers  decoders that read it, with the tilt to which they do
    """

    number: int
    name: str
    status: Status
    note: str = ""
    version: int | None = None
    bridges: int | None = None
    weakest: str = ""
    readers: str = ""

    @property
    def is_there(self) -> bool:
        """Whether the row's files are there."""
        return self.status in ("made", "kept")

    def as_dict(self) -> dict[str, Any]:
        return asdict(self)


def make_row(order: Order) -> Outcome:
    """The row's part, written; what is wrong with the row becomes its note."""
    from perfqr_cad import catalog

    try:
        template = catalog.load(Path(order.template))
        design = template.build(template.values(order.values), timeout_s=order.timeout_s).written(
            order.outputs
        )
    except NotHeldError as error:
        return Outcome(order.number, order.name, "not held", str(error))
    except PerfQRError as error:
        return Outcome(order.number, order.name, "refused", str(error))
    weakest = min(design.reinforcement.capacities, key=lambda one: one.bears_n / one.asked_n, default=None)
    read = {name: design.scan.decoders[name].max_tilt_deg for name in design.scan.readers}
    return Outcome(
        order.number,
        order.name,
        "made",
        version=design.symbol.version,
        bridges=len(design.pattern.bridges),
        weakest="" if weakest is None else weakest.words,
        readers=", ".join(f"{name} {tilt_deg:g}°" for name, tilt_deg in read.items()),
    )


def is_whole(order: Order) -> bool:
    """Whether every file of the order is there as its certificate says."""
    certificates = [Path(output) for output in order.outputs if output.endswith(".json")]
    try:
        listed = {
            certificate.parent / record["path"]: record["sha256"]
            for certificate in certificates
            for record in json.loads(certificate.read_bytes())["files"]
        }
        others = {Path(output) for output in order.outputs} - set(certificates)
        digests = {path: hashlib.sha256(path.read_bytes()).hexdigest() for path in others}
    except (OSError, ValueError, KeyError, TypeError):  # gone, cut short, or another's file of that name
        return False
    return bool(certificates) and digests == listed
