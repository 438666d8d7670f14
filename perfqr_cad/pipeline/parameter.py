"""A declared value: name, kind, default, range and meaning, and the only check of what is given for it.

The settings of `make` (`pipeline.request`) and the own parameters of a template (`catalog`) are both this.
"""

from __future__ import annotations

import keyword
import math
import unicodedata
from dataclasses import dataclass
from typing import Any

from perfqr_cad.errors import DesignError
from perfqr_cad.pipeline.kinds import Kind, Value, is_nothing, shown, value_of

_JSON_TYPES = {
    Kind.TEXT: "string",
    Kind.FLAG: "boolean",
    Kind.WHOLE: "integer",
    Kind.NUMBER: "number",
    Kind.VECTOR: "array",
    Kind.VECTORS: "array",
}


@dataclass(frozen=True)
class Parameter:
    """One value that can be set.

    name         as on the command line and in a template; `field` is its name in Python, with the unit
    minimum, step, maximum   bound a number, or each entry of a vector; the step is advice
    choices      `(value, label)` pairs; case does not matter for texts
    max_length   letters of a text
    lengths      how many numbers a vector has
    empty        what the program does where nothing is given; None: there must be a value
    form         how the value is written, for kinds that need telling
    visible      a text must have a letter that can be seen
    needs        what gives it an effect, any one of them: another setting, a value of it (`finder=recessed`),
                 or a kind of file (`.dxf`)
    example      what a template has before anything is given, where the default is nothing
    """

    name: str
    default: Value
    kind: Kind
    description: str = ""
    group: str = "Parameters"
    unit: str = ""
    minimum: float | None = None
    step: float | None = None
    maximum: float | None = None
    choices: tuple[tuple[Value, str], ...] = ()
    max_length: int | None = None
    lengths: tuple[int, ...] = ()
    empty: str | None = None
    form: str = ""
    visible: bool = False
    needs: tuple[str, ...] = ()
    example: Value = None
    field: str = ""

    @property
    def python_name(self) -> str:
        """The name in a template's own file: `yield_`, since `yield` is a word of Python."""
        return f"{self.name}_" if keyword.iskeyword(self.name) else self.name

    @property
    def option(self) -> str:
        """The name on the command line."""
        return f"--{self.name.replace('_', '-')}"

    @property
    def left_open(self) -> float | None:
        """The number that stands for "not given": 0 where that is out of range, else -1; or None."""
        if self.empty is None or self.kind not in (Kind.WHOLE, Kind.NUMBER):
            return None
        return -1 if self.minimum is None or self.minimum <= 0 else 0

    @property
    def limits(self) -> str:
        """The allowed values in OpenSCAD's own notation, empty when anything of the kind goes."""
        if self.choices:
            return "[" + ", ".join(_choice_text(value, label) for value, label in self.choices) + "]"
        if self.minimum is not None or self.maximum is not None:
            parts = [self.minimum, self.step, self.maximum]
            return "[" + ":".join(f"{p:.10g}" for p in parts if p is not None) + "]"
        return "" if self.max_length is None else f"at most {self.max_length} characters"

    @property
    def wanted(self) -> str:
        """What may be given, in words: "1 to 10000 mm"."""
        if self.choices:
            return "one of " + ", ".join(shown(value).strip("'") for value, _ in self.choices)
        if self.form:
            return self.form
        low, high = self.minimum, self.maximum
        if low is None and high is None:
            return f"{self._noun}{self._unit}" if self.kind is not Kind.ANY else ""
        if low is None or high is None:
            return f"at most {high:.10g}{self._unit}" if low is None else f"at least {low:.10g}{self._unit}"
        return f"{low:.10g} to {high:.10g}{self._unit}"

    def read(self, given: object) -> Value:
        """A value from a template, a parameter set or the command line: letters are read as this kind.

        Nothing, or the number that stands for it, is None where the program may choose. Raises
        `DesignError` as `check` does.
        """
        if self.empty is not None and is_nothing(self.kind, given):
            return None
        try:
            value = value_of(self.kind, given)
        except ValueError:
            raise self._refusal(given) from None
        if self.left_open is not None and value == self.left_open:
            return None
        return self.check(value)

    def check(self, given: object, name: str | None = None) -> Value:
        """`given` as a value of this kind and within its limits; `name` is what messages call it.

        Raises `DesignError`: value, limit, remedy.
        """
        name = name or self.name
        if given is None and self.empty is not None:
            return None
        try:
            value = value_of(self.kind, given)
        except ValueError:
            raise self._refusal(given, name) from None
        if isinstance(value, str):
            self._check_text(value, name)
        for number in _numbers(value):
            self._check_number(number, name)
        self._check_lengths(value, name)
        if self.choices:
            value = self._chosen(value, name)
        return self._whole(value) if isinstance(value, float) else value

    def schema(self) -> dict[str, Any]:
        """This value in JSON Schema (draft 2020-12)."""
        made: dict[str, Any] = {"description": self.meaning, "default": self.default}
        if (kind := _JSON_TYPES.get(self.kind)) is not None:
            made["type"] = [kind, "null"] if self.empty is not None else kind
        bounds = {"minimum": self.minimum, "maximum": self.maximum}
        bounds = {name: bound for name, bound in bounds.items() if bound is not None}
        if self.kind is Kind.VECTOR:
            made["items"] = {"type": "number", **bounds}
            made |= {"minItems": min(self.lengths), "maxItems": max(self.lengths)} if self.lengths else {}
        elif self.kind is Kind.VECTORS:
            made["items"] = {"type": "array", "items": {"type": "number"}}
        else:
            made |= bounds
        if self.choices:
            values = [value for value, _ in self.choices]
            made["enum"] = [*values, None] if self.empty is not None else values
        if self.max_length is not None:
            made["maxLength"] = self.max_length
        if self.unit:
            made["unit"] = self.unit
        return made

    @property
    def meaning(self) -> str:
        """The description, and what happens where nothing is given."""
        return self.description if not self.empty else f"{self.description} (not given: {self.empty})"

    @property
    def _unit(self) -> str:
        """The unit behind a number."""
        return self.unit if self.unit in ("", "°") else f" {self.unit}"

    @property
    def _noun(self) -> str:
        if self.kind in (Kind.VECTOR, Kind.VECTORS) and self.lengths:
            return f"{self.kind.value} of {' or '.join(str(n) for n in self.lengths)} numbers"
        return self.kind.value

    def _refusal(self, given: object, name: str | None = None) -> DesignError:
        name = name or self.name
        if given is None:
            return DesignError(f"{name} needs a value: give {self.wanted}")
        verb = "is neither" if self.kind is Kind.FLAG else "is no"
        noun = self._noun.replace(" or ", " nor ") if self.kind is Kind.FLAG else self._noun
        remedy = f": give {self.wanted}" if self.wanted != self._noun else ""
        return DesignError(f"{name}={shown(given)} {verb} {noun}{remedy}")

    def _check_text(self, text: str, name: str) -> None:
        if self.max_length is not None and len(text) > self.max_length:
            raise DesignError(
                f"{name} has {len(text)} characters, limit {self.max_length}: shorten it to {self.max_length}"
            )
        if self.visible and not any(_can_be_seen(letter) for letter in text):
            what = "empty" if not text else "of blanks alone"
            raise DesignError(f"the {name} is {what}: give at least 1 character that can be seen")

    def _check_number(self, number: float, name: str) -> None:
        if not math.isfinite(number):
            raise DesignError(f"{name}={number:g} is not a finite number: give {self.wanted}")
        low = -math.inf if self.minimum is None else self.minimum
        high = math.inf if self.maximum is None else self.maximum
        if not low <= number <= high:
            raise DesignError(
                f"{name}={number:g}{self._unit} is outside {low:.10g} to {high:.10g}{self._unit}: "
                "choose a value within"
            )

    def _check_lengths(self, value: Value, name: str) -> None:
        vectors: tuple[Any, ...] = {Kind.VECTOR: (value,), Kind.VECTORS: value}.get(self.kind, ())  # pyright: ignore
        for vector in vectors if self.lengths else ():
            if len(vector) not in self.lengths:
                raise self._refusal(vector, name)

    def _chosen(self, value: Value, name: str) -> Value:
        folded = value.lower() if isinstance(value, str) else value
        for choice, _ in self.choices:
            if choice == value:
                return choice
        for choice, _ in self.choices:
            if isinstance(choice, str) and choice.lower() == folded:
                return choice
        raise DesignError(f"{name}={shown(value)} is not {self.wanted}: choose one of them")

    def _whole(self, number: float) -> float:
        """A number as a whole one where a template's default is, so that it can count with it."""
        counts = isinstance(self.default, int) and not isinstance(self.default, bool)
        steps_whole = self.step is None or float(self.step).is_integer()
        return int(number) if counts and steps_whole and number.is_integer() else number


def _numbers(value: Value) -> tuple[float, ...]:
    if isinstance(value, bool):
        return ()
    if isinstance(value, int | float):
        return (value,)
    if isinstance(value, tuple):
        return tuple(number for entry in value for number in _numbers(entry))
    return ()


def _can_be_seen(letter: str) -> bool:
    return not letter.isspace() and unicodedata.category(letter) not in ("Cc", "Cf")


def _choice_text(value: Value, label: str) -> str:
    text = shown(value).strip("'")
    return text if text == label else f"{text}:{label}"
