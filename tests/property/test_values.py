"""The reader of values: what a kind takes comes back as it was meant, all else is one line."""

import json
import math

from hypothesis import given, settings
from hypothesis import strategies as st

from perfqr_cad.errors import DesignError
from perfqr_cad.pipeline.kinds import Kind, shown, value_of
from perfqr_cad.pipeline.parameter import Parameter
from perfqr_cad.pipeline.request import SETTINGS

EXAMPLES = settings(max_examples=200, deadline=None)
# What looks like something else: numbers, words of Python and JSON, quotes, vectors.
LOOKS = st.one_of(
    st.text(),
    st.from_regex(r"\A[-+ ]?[0-9_.]{1,12}([eE][-+]?[0-9]{1,3})?[ ]?\Z"),
    st.sampled_from(
        ["true", "None", "undef", "[1, 2]", "0x1F", "1_000", "nan", "-inf", "{[]: 1}", '"a"', "'"]
    ),
    st.integers().map(str),
    st.floats().map(str),
)
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=3),
)
PARAMETERS = [
    *SETTINGS,
    Parameter("at", (1.0, 2.0), Kind.VECTOR, lengths=(2,)),
    Parameter("any", None, Kind.ANY, empty=""),
    Parameter("few", 3, Kind.NUMBER, minimum=1, maximum=9),
]


@EXAMPLES
@given(LOOKS)
def test_a_text_comes_back_letter_by_letter(text: str) -> None:
    assert value_of(Kind.TEXT, text) == text


@EXAMPLES
@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_number_comes_back_to_the_bit(number: float) -> None:
    for letters in (repr(number), f" {number!r} ", json.dumps(number), f"{number:.17g}"):
        assert value_of(Kind.NUMBER, letters) == number


@EXAMPLES
@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), max_size=5))
def test_a_vector_comes_back(numbers: list[float]) -> None:
    assert value_of(Kind.VECTOR, json.dumps(numbers)) == tuple(numbers)
    assert value_of(Kind.VECTOR, numbers) == tuple(numbers)


def is_json_number(letters: str) -> bool:
    """Whether JSON takes it for a number: `NaN` and the infinities are none."""
    try:
        read = json.loads(letters, parse_constant=str)
    except ValueError:
        return False
    return isinstance(read, int | float) and not isinstance(read, bool)


@EXAMPLES
@given(LOOKS)
def test_letters_are_a_number_exactly_where_json_or_openscad_write_one(letters: str) -> None:
    try:
        number = value_of(Kind.NUMBER, letters)
    except ValueError:
        assert not is_json_number(letters)
    else:
        assert isinstance(number, float)
        assert not math.isnan(number)
        assert not set(letters.strip().lower()) - set("0123456789+-.e")


@EXAMPLES
@given(st.sampled_from(PARAMETERS), JSON | LOOKS)
def test_anything_is_a_value_within_its_limits_or_one_line(declared: Parameter, given_value: object) -> None:
    told = ""
    try:
        value = declared.read(given_value)
    except DesignError as error:
        told = str(error).replace(shown(given_value), "")  # what was given may hold any word
    else:
        assert declared.check(value) == value
        if declared.kind is Kind.TEXT and isinstance(value, str) and not declared.choices:
            assert value == given_value
    assert len(told.splitlines()) <= 1
    assert len(told) < 300
    assert not any(word in told for word in ("None", "True", "False", "tuple"))


@EXAMPLES
@given(JSON | LOOKS)
def test_every_value_can_be_shown(value: object) -> None:
    assert len(shown(value)) <= 60
    assert "\n" not in shown(value)
