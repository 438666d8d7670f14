"""Texts made of parts, beside segno's own helpers, and what cannot be meant."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from segno import helpers

from perfqr_cad.content import link, message
from perfqr_cad.errors import DesignError
from perfqr_cad.symbol import Matrix, recover


@pytest.mark.parametrize(
    ("kind", "given", "text"),
    [
        ("url", "example.com", "https://example.com"),
        ("url", "https://exämple.org/a b?q=ü;x=1#top", "https://xn--exmple-cua.org/a%20b?q=%C3%BC;x=1#top"),
        ("url", "https://example.com/%C3%BC", "https://example.com/%C3%BC"),
        ("url", "http://user@example.com:8080/x", "http://user@example.com:8080/x"),
        ("wifi", "Guests", "WIFI:S:Guests;;"),
        ("wifi", "ssid=Lab; password=p=1", "WIFI:T:WPA;S:Lab;P:p=1;;"),
        (
            "wifi",
            r"ssid=a\;b,c;password=x:y;security=WEP;hidden=yes",
            r"WIFI:T:WEP;S:a\;b,c;P:x\:y;H:true;",
        ),
        ("tel", "+41 (44) 668-18.00", "tel:+41446681800"),
        ("sms", "to=+41446681800; text=Hello", "SMSTO:+41446681800:Hello"),
        ("geo", "47.3769, 8.5417", "geo:47.3769,8.5417"),
        ("email", "a@example.com", "mailto:a@example.com"),
        ("email", "to=a@example.com;subject=Hi there", "mailto:a@example.com?subject=Hi%20there"),
        ("gs1", "(01)09506000134352(10)AB-1", "010950600013435210AB-1"),
    ],
)
def test_messages(kind: str, given: str, text: str) -> None:
    assert message(kind, given) == text


def test_a_business_card_is_that_of_segno() -> None:
    made = message("vcard", "Erika Muster; org=Muster AG; phone=+41446681800; city=Zürich")
    assert made == helpers.make_vcard_data(
        "Muster;Erika", "Erika Muster", org="Muster AG", phone="+41446681800", city="Zürich"
    )
    own = message("vcard", "name=Erika van Muster; family=van Muster; given=Erika")
    assert "N:van Muster;Erika" in own


@pytest.mark.parametrize(
    "more", [{"reference": "RF18539007547034"}, {"text": "Thank you", "bic": "BHBLDEHHXXX"}]
)
def test_a_transfer_is_that_of_segno(more: dict[str, str]) -> None:
    parts = ";".join(f"{name}={value}" for name, value in more.items())
    made = message("epc", f"name=Franz Mustermänn;iban=DE71 1102 2033 0123 4567 89;amount=12.35;{parts}")
    iban = "DE71110220330123456789"
    theirs = helpers.make_epc_qr("Franz Mustermänn", iban, 12.35, encoding="utf-8", **more)
    assert made == recover(Matrix.from_array(np.array(theirs.matrix, bool))).payload.text


@pytest.mark.parametrize(
    ("times", "lines"),
    [
        ("start=2027-05-01", ["DTSTART;VALUE=DATE:20270501"]),
        ("start=2027-05-01T10:00;end=2027-05-01T11:30", ["DTSTART:20270501T100000", "DTEND:20270501T113000"]),
        ("start=2027-05-01T10:00+02:00", ["DTSTART:20270501T080000Z"]),
    ],
)
def test_times_of_events(times: str, lines: list[str]) -> None:
    made = message("event", f"title=A, b\\; c;{times};place=Hall 3")
    assert made.split("\r\n") == [
        "BEGIN:VEVENT", r"SUMMARY:A\, b\; c", *lines, "LOCATION:Hall 3", "END:VEVENT"
    ]  # fmt: skip


def test_parts_from_a_file(tmp_path: Path) -> None:
    file = tmp_path / "wifi.txt"
    file.write_text("ssid=Work;shop\npassword=a;b\n", encoding="utf-8")
    assert message("wifi", f"@{file}") == r"WIFI:T:WPA;S:Work\;shop;P:a\;b;;"


@pytest.mark.parametrize(
    ("kind", "given", "told"),
    [
        ("url", "https://", "has no host"),
        ("wifi", "password=x", "wifi needs ssid"),
        ("wifi", "ssid=a;pass=b", "wifi has no part 'pass': it has ssid, password, security, hidden"),
        ("wifi", "ssid=a;b", "wifi has no part 'b'"),
        ("wifi", "ssid=a;ssid=b", "ssid is given twice"),
        ("wifi", "ssid=a;security=WPA", "security WPA needs a password"),
        ("wifi", "ssid=a;security=nopass;password=b", "security nopass takes no password"),
        ("wifi", "ssid=a;security=WPA9;password=b", "security 'WPA9' is unknown"),
        ("event", "title=a", "event needs start"),
        ("event", "title=a;start=tomorrow", "is no ISO 8601 time"),
        ("event", "title=a;start=2027-05-02;end=2027-05-01", "is before start"),
        ("geo", "91,0", "outside ±90,±180"),
        ("geo", "here", "is no place"),
        ("tel", "call me", "is no telephone number"),
        ("email", "nobody", "is no address"),
        ("epc", "name=A;iban=DE71110220330123456788;amount=1", "check digits are wrong"),
        ("epc", "name=A;iban=DE71110220330123456789;amount=0", "amount 0 is outside"),
        ("epc", "name=A;iban=DE71110220330123456789;amount=1;text=a;reference=b", "one of them"),
        ("gs1", "(01)09506000134351", "wrong check digit, 2 is right"),
        ("gs1", "0109506000134352", "is no element string"),
        ("wifi", "@/dev/zero", "a device, not a file"),
    ],
)
def test_what_cannot_be_meant_is_one_line(kind: str, given: str, told: str) -> None:
    with pytest.raises(DesignError, match=told) as refused:
        message(kind, given)
    assert "\n" not in str(refused.value)


def test_a_link_needs_a_key_and_a_domain() -> None:
    assert link("(01)09506000134352", "example.com") == "https://example.com/01/09506000134352"
    with pytest.raises(DesignError, match="has no key of a Digital Link"):
        link("(10)AB", "example.com")
    with pytest.raises(DesignError, match="has no host"):
        link("(01)09506000134352", "https://")
