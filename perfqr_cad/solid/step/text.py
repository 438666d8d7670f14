"""STEP physical files (ISO 10303-21): numbered entities, numbers, strings, header."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from io import StringIO

# ISO 10303-442 (AP242), managed model based 3D engineering.
SCHEMA = "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF { 1 0 10303 442 3 1 4 }"
PROTOCOL = ("ap242_managed_model_based_3d_engineering", 2020)
# A fixed time stamp: the same part gives the same bytes.
TIME_STAMP = "1970-01-01T00:00:00"
# Lengths to 1e-10 mm, directions and knots to 1e-13: below the kernel's 1e-7 at any size of part.
LENGTH_DIGITS = 10
UNIT_DIGITS = 13


class Part21:
    """The data section as it grows. Entities are referred to by number."""

    def __init__(self) -> None:
        self._lines: list[str] = []
        self._known: dict[str, int] = {}

    def add(self, entity: str) -> int:
        """A new entity; its number."""
        self._lines.append(entity)
        return len(self._lines)

    def add_all(self, entities: Iterable[str]) -> range:
        """New entities, which may add others as they come; their numbers."""
        found = list(entities)
        self._lines += found
        return range(len(self._lines) - len(found) + 1, len(self._lines) + 1)

    def shared_all(self, entities: Iterable[str]) -> list[int]:
        """As `shared`, of many."""
        return [self.shared(entity) for entity in entities]

    def shared(self, entity: str) -> int:
        """The number of an entity of this text, new only if there is none yet."""
        known = self._known.get(entity)
        if known is None:
            known = self._known[entity] = self.add(entity)
        return known

    def file(self, name: str, product: str) -> str:
        """The whole file as text."""
        out = StringIO()
        out.write(
            "ISO-10303-21;\nHEADER;\n"
            f"FILE_DESCRIPTION(({text(product)}),'2;1');\n"
            f"FILE_NAME({text(name)},'{TIME_STAMP}',(''),(''),'perfqr-cad','perfqr-cad','');\n"
            f"FILE_SCHEMA(('{SCHEMA}'));\nENDSEC;\nDATA;\n"
        )
        out.writelines(f"#{i}={entity};\n" for i, entity in enumerate(self._lines, 1))
        out.write("ENDSEC;\nEND-ISO-10303-21;\n")
        return out.getvalue()


@lru_cache(maxsize=1 << 16)  # coordinates of a grid of modules come again and again
def real(value: float, digits: int = LENGTH_DIGITS) -> str:
    """A number with the decimal point that Part 21 asks for; no negative zero.

    >>> real(2.0), real(-1e-12), real(2.5e-7)
    ('2.', '0.', '2.5E-7')
    """
    digits_of = repr(round(value, digits) + 0.0)
    if "e" in digits_of:
        mantissa, exponent = digits_of.split("e")
        return f"{mantissa if '.' in mantissa else mantissa + '.'}E{int(exponent)}"
    return digits_of[:-1] if digits_of.endswith(".0") else digits_of


def reals(values: Iterable[float], digits: int = LENGTH_DIGITS) -> str:
    return "(" + ",".join([real(v, digits) for v in values]) + ")"


def refs(numbers: Iterable[int]) -> str:
    """A list of references."""
    return "(" + ",".join([f"#{n}" for n in numbers]) + ")"


def text(value: str) -> str:
    r"""A quoted string; what is not printable ASCII as \X2\ or \X4\ (ISO 10303-21 §6.4.3)."""
    out: list[str] = []
    for char in value:
        code = ord(char)
        if char in "'\\":
            out.append(char * 2)
        elif 32 <= code < 127:
            out.append(char)
        elif code < 0x10000:
            out.append(f"\\X2\\{code:04X}\\X0\\")
        else:
            out.append(f"\\X4\\{code:08X}\\X0\\")
    return "'" + "".join(out) + "'"
