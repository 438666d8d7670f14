"""The text that parts make, by kind of content; each cites where its form is laid down."""

from __future__ import annotations

import re
from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any
from urllib.parse import quote, urlsplit

Parts = Mapping[str, str]

WHOLE = "whole"  # the name of a value that is not cut into parts
_URL_LETTERS = "!#$%&'()*+,/:;=?@[]~"  # RFC 3986 §2.2, and %: what is escaped already stays
_SECURITIES = ("WPA", "WEP", "nopass")


def url(parts: Parts) -> str:
    """An address with a scheme, a host in ASCII (IDNA) and all else escaped (RFC 3986)."""
    given = parts[WHOLE]
    address = urlsplit(given if "://" in given else f"https://{given}")
    if not address.hostname:
        raise ValueError(f"{given!r} has no host: write https://example.com/…")
    host = address.hostname if address.hostname.isascii() else address.hostname.encode("idna").decode()
    place = address.netloc.replace(address.netloc.rpartition("@")[2].partition(":")[0], host)
    return quote(address._replace(netloc=place).geturl(), safe=_URL_LETTERS)


def wifi(parts: Parts) -> str:
    """A login as phones agree on it (ZXing's wiki, "Barcode Contents")."""
    from segno.helpers import make_wifi_data

    secret = parts.get("password")
    security = parts.get("security", "WPA" if secret else "nopass")
    if security not in _SECURITIES:
        raise ValueError(f"security {security!r} is unknown: use {', '.join(_SECURITIES)}")
    if (security == "nopass") == bool(secret):
        raise ValueError(f"security {security} {'takes no' if secret else 'needs a'} password")
    hidden = parts.get("hidden", "no").lower() in ("yes", "true", "1")
    return make_wifi_data(parts["ssid"], secret, None if security == "nopass" else security, hidden)


def vcard(parts: Parts) -> str:
    """A business card (vCard 3.0, RFC 2426)."""
    from segno.helpers import make_vcard_data

    name = parts["name"]
    first, _, last = name.rpartition(" ")
    more: dict[str, Any] = {k: v for k, v in parts.items() if k not in ("name", "family", "given")}
    return make_vcard_data(f"{parts.get('family', last)};{parts.get('given', first)}", name, **more)


def event(parts: Parts) -> str:
    """An event of iCalendar (RFC 5545 §3.6.1) alone, as scanners of phones take it."""
    lines = ["BEGIN:VEVENT", f"SUMMARY:{_escaped(parts['title'])}", f"DTSTART{_moment(parts['start'])}"]
    if "end" in parts:
        if _time(parts["end"]) < _time(parts["start"]):
            raise ValueError(f"end {parts['end']} is before start {parts['start']}")
        lines.append(f"DTEND{_moment(parts['end'])}")
    lines += [
        f"{field}:{_escaped(parts[name])}"
        for name, field in (("place", "LOCATION"), ("text", "DESCRIPTION"), ("url", "URL"))
        if name in parts
    ]
    return "\r\n".join([*lines, "END:VEVENT"])


def _time(given: str) -> datetime:
    try:
        return datetime.fromisoformat(given).astimezone(UTC)
    except ValueError:
        raise ValueError(f"time {given!r} is no ISO 8601 time: write 2027-05-01T10:00") from None


def _moment(given: str) -> str:
    """A property's value: a day, a local time, or a time in UTC where the zone is told (RFC 5545 §3.3.5)."""
    time = _time(given)
    if len(given) <= len("2027-05-01"):
        return f";VALUE=DATE:{datetime.fromisoformat(given):%Y%m%d}"
    local = datetime.fromisoformat(given)
    return f":{local:%Y%m%dT%H%M%S}" if local.tzinfo is None else f":{time:%Y%m%dT%H%M%S}Z"


def _escaped(text: str) -> str:
    """A text of iCalendar (RFC 5545 §3.3.11)."""
    return re.sub(r"([\\;,])", r"\\\1", text).replace("\n", "\\n")


def geo(parts: Parts) -> str:
    """A place (RFC 5870)."""
    from segno.helpers import make_geo_data

    try:
        latitude, longitude = (float(part) for part in parts[WHOLE].split(","))
    except ValueError:
        raise ValueError(f"{parts[WHOLE]!r} is no place: give latitude,longitude in degrees") from None
    if not (abs(latitude) <= 90 and abs(longitude) <= 180):
        raise ValueError(f"{latitude:g},{longitude:g} is outside ±90,±180 degrees")
    return make_geo_data(latitude, longitude)


def epc(parts: Parts) -> str:
    """A SEPA credit transfer (EPC069-12, version 002, UTF-8)."""
    iban = re.sub(r"\s", "", parts["iban"]).upper()
    digits = "".join(str(int(letter, 36)) for letter in iban[4:] + iban[:4] if letter.isalnum())
    if not re.fullmatch(r"[A-Z]{2}\d{2}[A-Z0-9]{11,30}", iban) or int(digits) % 97 != 1:
        raise ValueError(f"iban {parts['iban']!r} is not valid: its check digits are wrong")
    amount = float(parts["amount"].replace(",", "."))
    if not 0.01 <= amount <= 999_999_999.99:
        raise ValueError(f"amount {amount:g} is outside 0.01 to 999999999.99 euros")
    if "reference" in parts and "text" in parts:
        raise ValueError("reference and text are both given: a transfer has one of them")
    fields = [
        "BCD", "002", "1", "SCT", parts.get("bic", ""), parts["name"], iban, f"EUR{amount:.2f}",
        parts.get("purpose", ""), parts.get("reference", ""), parts.get("text", ""),
    ]  # fmt: skip
    return "\n".join(fields).rstrip("\n")


def sms(parts: Parts) -> str:
    """A short message, as phones agree on it."""
    return f"SMSTO:{_number(parts['to'])}:{parts.get('text', '')}"


def tel(parts: Parts) -> str:
    """A telephone number (RFC 3966)."""
    return f"tel:{_number(parts[WHOLE])}"


def _number(given: str) -> str:
    """A telephone number without the marks that people write (RFC 3966)."""
    number = re.sub(r"[\s().\-/]", "", given)
    if not re.fullmatch(r"\+?[\d*#]{2,20}", number):
        raise ValueError(f"{given!r} is no telephone number: write +41446681800")
    return number


def email(parts: Parts) -> str:
    """A letter to be sent (RFC 6068)."""
    from segno.helpers import make_make_email_data

    if not re.fullmatch(r"[^@\s]+@[^@\s]+", parts["to"]):
        raise ValueError(f"{parts['to']!r} is no address: write name@example.com")
    return make_make_email_data(**parts)
