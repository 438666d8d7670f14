"""Texts cut into segments that take the fewest bits."""

from __future__ import annotations

from itertools import product

import pytest

from perfqr_cad.symbol import encode, payload_of
from perfqr_cad.symbol.payload import ALPHANUMERIC
from perfqr_cad.symbol.segmentation import segmentation
from perfqr_cad.symbol.tables import count_bits


def bits(parts: list[tuple[str, str]], version: int) -> int:
    """Length as ISO/IEC 18004 §7.4.3 to §7.4.5 count it."""
    total = 0
    for mode, text in parts:
        n = len(text)
        body = {
            "numeric": 10 * (n // 3) + (0, 4, 7)[n % 3],
            "alphanumeric": 11 * (n // 2) + 6 * (n % 2),
            "byte": 8 * n,
        }[mode]
        total += 4 + count_bits(mode, version) + body
    return total


def all_ways(text: str) -> list[list[tuple[str, str]]]:
    kinds = [
        ["byte", *(["alphanumeric"] if c in ALPHANUMERIC else []), *(["numeric"] if c.isdigit() else [])]
        for c in text
    ]
    ways = []
    for modes in product(*kinds):
        parts: list[tuple[str, str]] = []
        for mode, letter in zip(modes, text, strict=True):
            if parts and parts[-1][0] == mode:
                parts[-1] = (mode, parts[-1][1] + letter)
            else:
                parts.append((mode, letter))
        ways.append(parts)
    return ways


@pytest.mark.parametrize("version", [1, 9, 10, 27])
@pytest.mark.parametrize("text", ["a1234567", "AB12345a", "12345678", "A1A1aA1A", "ab:1234Z", "0", "A-B"])
def test_no_cut_is_shorter(text: str, version: int) -> None:
    parts = list(segmentation(text, version))
    assert "".join(part for _, part in parts) == text
    assert bits(parts, version) == min(bits(way, version) for way in all_ways(text))


@pytest.mark.parametrize(
    "text", ["https://example.com/p/1234567", "WIFI:T:WPA;S:LAB-2;P:000111222333;;", "ABC" + "7" * 40 + "def"]
)
def test_mixed_mode_keeps_the_text_and_is_never_longer(text: str) -> None:
    plain, mixed = encode(text), encode(text, mode="mixed")
    assert payload_of(mixed).text == text
    assert len(payload_of(mixed).segments) > 1
    assert payload_of(mixed).used_bits < payload_of(plain).used_bits
    assert mixed.version <= plain.version


@pytest.mark.parametrize("version", [10, 30])
def test_the_cut_is_that_of_the_version_in_the_end(version: int) -> None:
    text = "a123456b" * 2
    parts = [
        (s.mode, s.data.decode()) for s in payload_of(encode(text, version=version, mode="mixed")).segments
    ]
    assert tuple(parts) == segmentation(text, version)


def test_other_letters_stay_one_segment() -> None:
    """Readers differ in how far the label of a character set reaches."""
    assert encode("grün 123456789", mode="mixed") == encode("grün 123456789")
    assert encode(b"123", mode="mixed") == encode(b"123")
