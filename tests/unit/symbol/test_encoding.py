"""Messages, versions, masks and pads."""

import pytest

from perfqr_cad.errors import SymbolError
from perfqr_cad.symbol import encode, free_codewords, payload_of, read_format, with_pads


def test_smallest_version_is_taken_and_the_text_comes_back() -> None:
    symbol = encode("https://example.com/p/1234567", level="M")
    assert symbol.version == 3
    assert payload_of(symbol).text == "https://example.com/p/1234567"


def test_text_too_long_names_length_capacity_and_remedies() -> None:
    with pytest.raises(SymbolError, match=r"needs 32 codewords, version 1-H holds 9: use --version 4$"):
        encode("https://example.com/p/1234567x", version=1, level="H")
    with pytest.raises(SymbolError, match=r"version 2-H holds 16: use --version 4 or --level L"):
        encode("https://example.com/p/1234567x", version=2, level="H")
    with pytest.raises(SymbolError, match=r"version 40-H holds 1276: use a shorter text"):
        encode("x" * 5000, level="H")


def test_level_that_fits_is_named() -> None:
    with pytest.raises(SymbolError, match=r"needs 2003 codewords, version 40-H holds 1276: use --level M$"):
        encode("x" * 2000, level="H")


def test_empty_text_and_half_a_surrogate_are_refused() -> None:
    with pytest.raises(SymbolError, match="the text is empty"):
        encode("")
    with pytest.raises(SymbolError, match=r"character 3 of the text, U\+D83D"):
        encode("ab\ud83d")


def test_mode_that_cannot_hold_the_text_is_refused() -> None:
    assert payload_of(encode("点茗", mode="kanji")).segments[0].mode == "kanji"
    assert payload_of(encode("123", mode="byte")).segments[0].mode == "byte"
    for mode, text in (("numeric", "12a"), ("alphanumeric", "abc"), ("kanji", "abc"), ("kanji", "é点")):
        with pytest.raises(SymbolError, match=f"{mode} mode cannot hold '{text}'"):
            encode(text, mode=mode)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"version": 41}, "version 41 does not exist"),
        ({"version": 0}, "version 0 does not exist"),
        ({"level": "X"}, "level 'X' does not exist"),
        ({"mask": 8}, "mask 8 does not exist"),
        ({"pads": b"\x00"}, "1 pad codewords given, 10 are free"),
    ],
)
def test_absurd_settings_are_refused(arguments: dict, message: str) -> None:
    with pytest.raises(SymbolError, match=message):
        encode("HELLO", **arguments)


def test_boost_raises_the_level_but_not_the_version() -> None:
    assert encode("HELLO", level="L", boost=True).level == "H"
    assert encode("x" * 17, level="L", boost=True).level == "L"


def test_pads_may_hold_anything_and_leave_the_message() -> None:
    symbol = encode("HELLO", version=2, level="L")
    free = free_codewords(symbol)
    other = with_pads(symbol, bytes(range(free)), mask=5)
    assert free == 34 - 6
    assert other.data[-free:] == bytes(range(free))
    assert other.codewords != symbol.codewords
    assert payload_of(other).text == "HELLO"
    assert read_format(other.matrix).mask == 5
    assert other == encode("HELLO", version=2, level="L", pads=bytes(range(free)), mask=5)
    with pytest.raises(SymbolError, match="2 pad codewords given, 28 are free"):
        with_pads(symbol, b"ab")
