"""Kinds of values, and how each is read: the kind of a parameter decides, never the look of what was written.

A text is kept letter by letter: `1.50`, `true` and blanks around it stay as they are. A number is decimal, as
OpenSCAD and JSON write it: `40`, `-.5`, `4e1`, but not `1_000` or `0x1F`.

>>> value_of(Kind.TEXT, "1.50"), value_of(Kind.NUMBER, "1.50"), value_of(Kind.VECTOR, "[3, 4]")
('1.50', 1.5, (3.0, 4.0))
"""

from __future__ import annotations

import re
from enum import Enum
from numbers import Real
from typing import Any

Vector = tuple[float, ...]
Value = bool | int | float | str | Vector | tuple[Vector, ...] | None


class Kind(Enum):
    """What a value is; the words are those that messages use."""

    TEXT = "text"
    FLAG = "true or false"
    WHOLE = "whole number"
    NUMBER = "number"
    VECTOR = "vector"
    VECTORS = "list of vectors"
    ANY = "value"  # undeclared: a number, vector, true or false where it reads as one, else a text


_DECIMAL = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_INTEGER = re.compile(r"[+-]?\d{1,15}", re.ASCII)
_FLAGS = {"true": True, "false": False}
_NOTHING = ("undef", "none", "null")  # OpenSCAD's, Python's and JSON's words for no value
_SHOWN = 40  # letters of a value that a message repeats
_DEPTH = 2  # lists in lists that it repeats
# Python's names for kinds, in annotations of settings and of a template's own parameters.
_NAMED = {"str": Kind.TEXT, "bool": Kind.FLAG, "int": Kind.WHOLE, "float": Kind.NUMBER}


def value_of(kind: Kind, given: object) -> Value:
    """`given` as a value of that kind: letters are read, values of the kind stay, lists become vectors.

    Raises `ValueError` for anything else.
    """
    match kind, given:
        case Kind.TEXT, str():
            given.encode()  # UnicodeEncodeError, a ValueError: bytes that are no letters
            return given
        case Kind.FLAG, bool():
            return given
        case Kind.FLAG, str() if given.strip().lower() in _FLAGS:
            return _FLAGS[given.strip().lower()]
        case Kind.WHOLE, str() | Real():
            return _whole(_number(given))
        case Kind.NUMBER, str() | Real():
            return _number(given)
        case Kind.VECTOR, str() | list() | tuple():
            return _vector(given)
        case Kind.VECTORS, str():
            return tuple(_vector(part) for part in given.split(";") if part.strip())
        case Kind.VECTORS, list() | tuple():
            return tuple(_vector([part] if isinstance(part, Real) else part) for part in given)
        case Kind.VECTORS, Real():
            return (_vector([given]),)
        case Kind.ANY, _:
            return _as_it_looks(given)
        case _:
            raise ValueError(f"no {kind.value}")


def is_nothing(kind: Kind, given: object) -> bool:
    """Whether nothing was given: no value, no letters, or `undef` where letters are not the value itself."""
    if not isinstance(given, str):
        return given is None or given == ()
    return not given if kind is Kind.TEXT else given.strip().lower() in ("", *_NOTHING)


def kind_of_literal(value: object) -> tuple[Kind, tuple[int, ...]] | None:
    """The kind of a default, and the length that a vector has; None for what is no parameter's value."""
    match value:
        case None:
            return Kind.ANY, ()
        case str():
            return Kind.TEXT, ()
        case bool():
            return Kind.FLAG, ()
        case int() | float():
            return Kind.NUMBER, ()
        case list() | tuple() if all(isinstance(v, int | float) and not isinstance(v, bool) for v in value):
            return Kind.VECTOR, (len(value),)
        case _:
            return None


def kind_of_annotation(annotation: str) -> tuple[Kind, tuple[int, ...], bool] | None:
    """Kind, lengths of its vectors and whether None is allowed, from a Python annotation; None for others.

    >>> kind_of_annotation("tuple[float, float, float] | None")
    (<Kind.VECTOR: 'vector'>, (3,), True)
    """
    optional = annotation.endswith("| None")
    bare = annotation.removesuffix("| None").replace(" ", "")
    if bare in _NAMED:
        return _NAMED[bare], (), optional
    if bare == "tuple[tuple[float,...],...]":
        return Kind.VECTORS, (), optional
    if vector := re.fullmatch(r"tuple\[(float(,float)*)\]", bare):
        return Kind.VECTOR, (vector.group(1).count("float"),), optional
    return None


def shown(value: object, nested: int = _DEPTH) -> str:
    """A value as messages and tables show it, cut short where it is long or deep."""
    match value:
        case None:
            text = "nothing"
        case bool():
            text = str(value).lower()
        case float():
            text = f"{value:g}"
        case list() | tuple() if nested:
            text = f"[{', '.join(shown(entry, nested - 1) for entry in value[:_SHOWN])}]"
        case list() | tuple() | dict():
            text = "a structure"
        case str() if nested < _DEPTH and _DECIMAL.fullmatch(value):
            text = value  # a number of a JSON list
        case str():
            some = value[: _SHOWN + 1]
            text = f"'{some}'" if some.isprintable() else ascii(some)
        case int() if abs(value) > 10**_SHOWN:  # Python writes none of more than 4,300 digits
            text = f"a number of over {_SHOWN} digits"
        case _:
            text = str(value)
    return text if len(text) <= _SHOWN + 2 else f"{text[:_SHOWN]}…"


def _number(given: Any) -> float:
    if isinstance(given, str):
        if not _DECIMAL.fullmatch(given.strip()):
            raise ValueError("no number")
    elif isinstance(given, bool) or not isinstance(given, Real):
        raise ValueError("no number")
    try:
        return float(given)
    except OverflowError:
        return float("inf")


def _whole(number: float) -> int:
    if not number.is_integer():  # infinite ones are not, either
        raise ValueError("no whole number")
    return int(number)


def _vector(given: Any) -> Vector:
    if not isinstance(given, str | list | tuple):
        raise ValueError("no vector")
    if isinstance(given, str):
        bare = given.strip()
        if bare[:1] + bare[-1:] in ("[]", "()"):
            bare = bare[1:-1]
        given = bare.split(",") if bare.strip() else []
    return tuple(_number(entry) for entry in given)


def _as_it_looks(given: object) -> Value:
    if isinstance(given, bool | int | float):
        return given
    kinds = [Kind.FLAG, Kind.NUMBER, Kind.TEXT]
    if not isinstance(given, str) or "," in given:
        kinds.insert(0, Kind.VECTOR)
    for kind in kinds:
        try:
            value = value_of(kind, given)
        except ValueError:
            continue
        return int(value) if isinstance(value, float) and _INTEGER.fullmatch(str(given)) else value
    raise ValueError("no value")
