"""Loads of a hand, by name and newtons: what a part is asked to bear unless something else is asked for."""

from __future__ import annotations

from dataclasses import dataclass

from perfqr_cad.errors import AnalysisError
from perfqr_cad.structure.loads import require_finite

FINGERTIP_PAD_MM = 8.0  # what of a finger bears, pressed lightly
WORDS = {
    "weight": "its own weight, held along one edge",
    "fingertip": "a fingertip",
    "push": "a push on one edge, the opposite one held",
    "bend": "three-point bending",
    "twist": "a twist by its corners",
    "peel": "lifting one edge off the print bed",
    "pressure": "an even pressure on its front",
}


@dataclass(frozen=True)
class HandlingLoad:
    """Something a hand does to a part, judged by itself.

    name          one of `WORDS`
    newtons       the force that the part is asked to bear; None: the weight of the part, or what
                  `pressure_mpa` makes on its front
    pressure_mpa  of the load "pressure" alone
    """

    name: str
    newtons: float | None
    pressure_mpa: float | None = None

    def __post_init__(self) -> None:
        if self.name not in WORDS:
            raise AnalysisError(f"load {self.name!r} is unknown; choose one of {', '.join(WORDS)}")
        if self.newtons is not None:
            require_finite(self.name, self.newtons, "N")
            if not self.newtons > 0.0:
                raise AnalysisError(f"{self.name} is {self.newtons:g} N; it must be more than 0")

    @property
    def words(self) -> str:
        """What is done, as a buyer would say it."""
        return WORDS[self.name]

    @property
    def stays(self) -> bool:
        """Whether it acts for years, so that plastics creep."""
        return self.name == "weight"

    @property
    def needs_no_support(self) -> bool:
        """Whether it is done to a part in the hand only, not to one that is mounted."""
        return self.name in ("push", "bend", "twist", "peel")


# Forces of a hand that is not careful: chosen, not measured. A key takes 0.5-0.8 N (ISO 9241-410), a test
# finger that must not break through a housing 10 N (IEC 61032).
HANDLING = (
    HandlingLoad("weight", None),
    HandlingLoad("fingertip", 5.0),
    HandlingLoad("push", 2.0),
    HandlingLoad("bend", 5.0),
    HandlingLoad("twist", 2.0),
    HandlingLoad("peel", 2.0),
)


def handling_loads(asked: tuple[str, ...], pressure_mpa: float = 0.0) -> tuple[HandlingLoad, ...]:
    """The loads that a part is asked to bear: those of a hand, changed by names with or without newtons.

    A name alone picks: then only what is named counts. A name with newtons sets that load.

    >>> [load.name for load in handling_loads(("fingertip", "bend=8"))]
    ['fingertip', 'bend']
    >>> next(load.newtons for load in handling_loads(("fingertip=9",)) if load.name == "fingertip")
    9.0

    Raises:
        AnalysisError: a name is unknown, or a force is no positive number.
    """
    usual = {load.name: load for load in HANDLING}
    given: dict[str, HandlingLoad] = {}
    picked = False
    for entry in asked:
        name, equals, newtons = entry.strip().partition("=")
        picked |= not equals
        if name == "handling" and not equals:
            given = usual | given
        elif equals:
            given[name] = HandlingLoad(name, _newtons(entry, newtons))
        elif name == "pressure":
            raise AnalysisError("load 'pressure' has no usual force: say how many newtons, as in pressure=5")
        else:
            given[name] = usual.get(name) or HandlingLoad(name, None)
    loads = given if picked else usual | given
    if pressure_mpa:
        loads = loads | {"pressure": HandlingLoad("pressure", None, pressure_mpa)}
    return tuple(loads.values())


def _newtons(entry: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise AnalysisError(f"load {entry!r} has no number of newtons: write fingertip=9, say") from None
