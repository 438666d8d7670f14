"""Where the symbol of a part comes from."""

from __future__ import annotations

import pytest

from perfqr_cad.errors import DesignError
from perfqr_cad.pipeline.certificate import chosen_words
from perfqr_cad.pipeline.chain import asked
from perfqr_cad.pipeline.resolve import resolve
from perfqr_cad.pipeline.source import Source, freedoms, in_capitals, source
from perfqr_cad.symbol import encode, payload_of

TEXT = "https://example.com/p/1234567"


def found(**settings: object) -> Source:
    request = asked(TEXT, size_mm=60, **settings)
    return source(request, resolve(request, plate=True))


def test_all_freedoms_by_default() -> None:
    assert freedoms(asked(TEXT)) == {"mask", "segment", "pad", "version"}
    made = found()
    assert made.choice is not None
    assert payload_of(made.symbol).text == TEXT
    fewer, many = len(made.choice.left.corners), len(made.choice.left_plain.corners)
    assert chosen_words(made.choice) == [
        f"chosen    rather than version 3-M, mask {made.choice.plain.mask}: {fewer} corners to be joined "
        f"instead of {many}, by the bits after its end"
    ]


@pytest.mark.parametrize("freedom", ["none", ""])
def test_none_is_the_ordinary_symbol(freedom: str) -> None:
    made = found(freedom=freedom)
    assert made.symbol == encode(TEXT)
    assert chosen_words(made.choice) == []


@pytest.mark.parametrize("freedom", ["mask", "mask, segment", "none,mask"])
def test_pads_stay_unless_they_are_free(freedom: str) -> None:
    made = found(freedom=freedom)
    assert made.choice is not None
    assert not made.choice.pads_are_free
    assert made.symbol.version == 3


def test_unknown_freedoms_are_named() -> None:
    with pytest.raises(DesignError, match="freedom 'pads' is unknown: use none, or some of mask,"):
        found(freedom="mask,pads")


def test_capitals_on_request_free_more_bits() -> None:
    made = found(freedom="mask,segment,pad,version,case")
    assert payload_of(made.symbol).text == "HTTPS://EXAMPLE.COM/p/1234567"
    assert payload_of(made.symbol).used_bits < payload_of(found().symbol).used_bits


@pytest.mark.parametrize(
    ("text", "capitals"),
    [
        ("https://example.com", "HTTPS://EXAMPLE.COM"),
        ("http://a.b:80?q=x", "HTTP://A.B:80?q=x"),
        ("https://user@example.com/x", "https://user@example.com/x"),
        ("WIFI:S:a;;", "WIFI:S:a;;"),
        ("mailto:a@b.c", "mailto:a@b.c"),
    ],
)
def test_only_scheme_and_host_become_capitals(text: str, capitals: str) -> None:
    assert in_capitals(text) == capitals
