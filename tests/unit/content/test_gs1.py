"""GS1 elements, beside biip's reading of them."""

from __future__ import annotations

import biip
import pytest

from perfqr_cad.content.gs1 import check_digit, digital_link, element_string, elements


@pytest.mark.parametrize(
    "written",
    [
        "(01)09506000134352",
        "(01)09506000134352(10)AB-1",
        "(10)AB-1(01)09506000134352",
        "(01)09506000134352(17)271231(10)A%B(21)X/1",
        "(00)306141411234567891",
        "(01)09506000134352(3103)000750(15)271231",
        "(414)9506000134369(8020)REF1",
        "(02)09506000134352(37)24(400)P0-1",
    ],
)
def test_biip_reads_the_same_elements(written: str) -> None:
    read = biip.parse(element_string(written)).gs1_message
    assert read is not None
    assert [(one.ai.ai, one.value) for one in read.element_strings] == elements(written)


@pytest.mark.parametrize("digits", ["0950600013435", "30614141123456789", "950600013436"])
def test_check_digits(digits: str) -> None:
    from biip.checksums import gs1_standard_check_digit

    assert check_digit(digits) == str(gs1_standard_check_digit(digits))


def test_links_have_qualifiers_in_their_order_and_the_rest_behind() -> None:
    written = "(01)09506000134352(21)S/1(10)AB(17)271231(3103)000750"
    assert digital_link(written, "https://id.gs1.org/") == (
        "https://id.gs1.org/01/09506000134352/10/AB/21/S%2F1?17=271231&3103=000750"
    )


@pytest.mark.parametrize(
    ("written", "told"),
    [
        ("", "is no element string"),
        ("(01)0950600013435", "has 13 digits, must have 14"),
        ("(17)2712", "has 4 digits, must have 6"),
        ("(10)", "cannot hold ''"),
        ("(10)a b", "cannot hold 'a b'"),
        ("x(10)a", "is no element string"),
        ("(00)306141411234567890", "wrong check digit, 1 is right"),
    ],
)
def test_what_is_wrong_is_told(written: str, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        elements(written)
