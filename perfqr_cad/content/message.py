r"""What a code says, made of parts: a Wi-Fi login, a business card, an event, …, with all escapes done.

A value is the main part alone, or parts as `name=value` with `;` between (`\;` for the letter itself), or
`@FILE` with one part a line.

>>> message("wifi", r"ssid=Work; password=a\;b")
'WIFI:T:WPA;S:Work;P:a\\;b;;'
>>> message("event", "title=Fair; start=2027-05-01T10:00; place=Hall 3").splitlines()[1:-1]
['SUMMARY:Fair', 'DTSTART:20270501T100000', 'LOCATION:Hall 3']
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from perfqr_cad.bounded import read_text
from perfqr_cad.content import forms
from perfqr_cad.content.forms import WHOLE, Parts
from perfqr_cad.content.gs1 import digital_link, element_string
from perfqr_cad.errors import DesignError

MOST_BYTES = 100_000  # of a file with parts; a code holds 3 kB
_NAMED_PART = re.compile(r"\s*([a-z]+)\s*=(.*)", re.DOTALL)


@dataclass(frozen=True)
class Content:
    """A kind of content: the names of its parts, the main one first, those it cannot do without, and the text
    that they make."""

    names: tuple[str, ...]
    needed: tuple[str, ...]
    text: Callable[[Parts], str]


def message(kind: str, given: str) -> str:
    """The text of the code. Raises `DesignError` for parts that are unknown, missing or cannot be meant."""
    content = CONTENTS[kind]
    found = {WHOLE: given.strip()} if content.names == (WHOLE,) else _parts(kind, given, content.names)
    for name in content.needed:
        if not found.get(name):
            raise DesignError(f"{kind} needs {name}: give --{kind} '{content.names[0]}=…; {name}=…'")
    try:
        return content.text(found)
    except ValueError as error:
        raise DesignError(f"{kind}: {error}") from error


def link(given: str, domain: str) -> str:
    """GS1 elements as an address of a domain. Raises `DesignError` as `message` does."""
    try:
        return digital_link(given.strip(), forms.url({WHOLE: domain}))
    except ValueError as error:
        raise DesignError(f"gs1: {error}") from error


def _parts(kind: str, given: str, names: tuple[str, ...]) -> dict[str, str]:
    """The parts by name."""
    if given.startswith("@"):
        written = read_text(
            given[1:], MOST_BYTES, DesignError, f"a file with the parts of {kind}"
        ).splitlines()
    else:
        written = re.split(r"(?<!\\);", given)
    found: dict[str, str] = {}
    for number, part in enumerate(filter(str.strip, written)):
        named = _NAMED_PART.fullmatch(part)
        name, value = (named[1], named[2]) if named else (names[0], part)
        if name not in names or (number and not named):
            unknown = name if named else part.strip()
            raise DesignError(
                f"{kind} has no part {unknown!r}: it has {', '.join(names)}; write ; within a part as \\;"
            )
        if name in found:
            raise DesignError(f"{kind}: {name} is given twice: give it once")
        found[name] = value.strip().replace("\\;", ";")
    return found


_CARD = (
    "email", "phone", "cellphone", "homephone", "workphone", "fax", "url", "org", "title", "street", "city",
    "region", "zipcode", "country", "birthday", "memo", "nickname",
)  # fmt: skip
_TRANSFER = ("name", "iban", "amount")
CONTENTS: Mapping[str, Content] = {
    "url": Content((WHOLE,), (), forms.url),
    "wifi": Content(("ssid", "password", "security", "hidden"), ("ssid",), forms.wifi),
    "vcard": Content(("name", "family", "given", *_CARD), ("name",), forms.vcard),
    "event": Content(("title", "start", "end", "place", "text", "url"), ("title", "start"), forms.event),
    "geo": Content((WHOLE,), (), forms.geo),
    "epc": Content(
        ("name", "iban", "amount", "text", "reference", "bic", "purpose"),
        ("name", "iban", "amount"),
        forms.epc,
    ),
    "sms": Content(("to", "text"), ("to",), forms.sms),
    "tel": Content((WHOLE,), (), forms.tel),
    "email": Content(("to", "cc", "bcc", "subject", "body"), ("to",), forms.email),
    "gs1": Content((WHOLE,), (), lambda parts: element_string(parts[WHOLE])),
}
