"""GS1 element strings (GS1 General Specifications §3, §7.8) and Digital Link addresses (its URI syntax)."""

from __future__ import annotations

import re
from collections.abc import Sequence
from urllib.parse import quote

GS = "\x1d"  # group separator, ends a value of open length where another follows
# The first two digits of identifiers whose length is fixed, and that length with them (Figure 7.8.5-2).
_FIXED = {
    "00": 20, "01": 16, "02": 16, "03": 16, "04": 18, "11": 8, "12": 8, "13": 8, "14": 8, "15": 8, "16": 8,
    "17": 8, "18": 8, "19": 8, "20": 4, "31": 10, "32": 10, "33": 10, "34": 10, "35": 10, "36": 10, "41": 16,
}  # fmt: skip
_CHECKED = ("00", "01", "02", "410", "411", "412", "413", "414", "415", "416", "417")  # end in a check digit
_KEYS = ("01", "00", "8006", "8010", "414", "417", "253", "255", "401", "402", "8003", "8004", "8017", "8018")
_QUALIFIERS = ("22", "10", "21", "235", "254", "7040")  # in the path behind the key, in this order
_VALUE = re.compile(r"[!\"%&'()*+,\-./0-9:;<=>?A-Z_a-z]{1,90}")  # GS1 character set 82


def elements(written: str) -> list[tuple[str, str]]:
    """Identifiers and values of `(01)09506000134352(10)AB-1`.

    Raises `ValueError` for what is no element string, for wrong lengths and for wrong check digits.
    """
    found = re.findall(r"\((\d{2,4})\)((?:(?!\(\d{2,4}\)).)*)", written)
    if not found or "".join(f"({ai}){value}" for ai, value in found) != written:
        raise ValueError(f"{written!r} is no element string: write (01)09506000134352(10)AB-1")
    for ai, value in found:
        if not _VALUE.fullmatch(value):
            raise ValueError(f"({ai}) cannot hold {value!r}: 1 to 90 letters of the GS1 set 82")
        if (length := _FIXED.get(ai[:2])) and len(ai + value) != length:
            raise ValueError(f"({ai}) has {len(value)} digits, must have {length - len(ai)}")
        if ai in _CHECKED and value[-1] != check_digit(value[:-1]):
            raise ValueError(f"({ai}){value} ends in a wrong check digit, {check_digit(value[:-1])} is right")
    return found


def check_digit(digits: str) -> str:
    """The last digit of a key (§7.9.1).

    >>> check_digit("0950600013435")
    '2'
    """
    if not digits.isdigit():
        raise ValueError(f"{digits!r} must be digits")
    total = sum(int(digit) * (3 if k % 2 == 0 else 1) for k, digit in enumerate(reversed(digits)))
    return str(-total % 10)


def element_string(written: str) -> str:
    r"""The data behind FNC1 in first position, with separators behind values of open length.

    >>> element_string("(10)AB-1(01)09506000134352")
    '10AB-1\x1d0109506000134352'
    """
    return _joined(elements(written))


def _joined(found: Sequence[tuple[str, str]]) -> str:
    return "".join(
        ai + value + ("" if ai[:2] in _FIXED or k == len(found) - 1 else GS)
        for k, (ai, value) in enumerate(found)
    )


def digital_link(written: str, domain: str) -> str:
    """The same elements as a web address.

    >>> digital_link("(01)09506000134352(17)271231(10)AB-1", "https://id.gs1.org")
    'https://id.gs1.org/01/09506000134352/10/AB-1?17=271231'
    """
    found = dict(elements(written))
    key = next((ai for ai in _KEYS if ai in found), None)
    if key is None:
        raise ValueError(f"{written!r} has no key of a Digital Link: give (01), say")
    path = [key, *(ai for ai in _QUALIFIERS if ai in found and ai != key)]
    steps = "".join(f"/{ai}/{quote(found[ai], safe='')}" for ai in path)
    query = "&".join(f"{ai}={quote(value, safe='')}" for ai, value in found.items() if ai not in path)
    return f"{domain.rstrip('/')}{steps}" + (f"?{query}" if query else "")
