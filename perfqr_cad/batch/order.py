"""What is to be made of a row: values of the template, and names of files."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from string import Formatter

from perfqr_cad import __version__
from perfqr_cad.batch.rows import Label
from perfqr_cad.catalog import Template
from perfqr_cad.errors import DesignError
from perfqr_cad.export import module_of
from perfqr_cad.pipeline.request import SOURCES

NAME = "name"  # the column that names files, if there is one
NUMBER = "row"  # in a pattern: the row's number
MOST_NAME = 120  # letters; file systems take 255 bytes, and a suffix is to come
# Names that Windows keeps for devices, with any suffix.
_DEVICES = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?", re.IGNORECASE)
_FORBIDDEN = re.compile(r'[\x00-\x1f<>:"/\\|?*]')


@dataclass(frozen=True)
class Order:
    """One part: the template, the values that it is given, and the files to write.

    number, name  of the row
    """

    number: int
    name: str
    template: str
    values: Mapping[str, str]
    outputs: tuple[str, ...]
    timeout_s: float

    def key(self, source: bytes) -> str:
        """What tells this part from any other that could be under its name: a SHA-256 in hexadecimal.

        source  of the template
        """
        said = json.dumps(asdict(self) | {"version": __version__}, sort_keys=True)
        return hashlib.sha256(said.encode("utf-8", "surrogatepass") + source).hexdigest()


@dataclass(frozen=True)
class Plan:
    """What all rows share.

    shared    values for all rows; `{column}` in a text stands for the row's cell
    pattern   of the files' names; None: the column `name`, or the row's number
    suffixes  of the files that are written for each row
    """

    template: Template
    shared: Mapping[str, str]
    folder: Path
    pattern: str | None
    suffixes: tuple[str, ...]
    timeout_s: float

    def orders(self, rows: Sequence[Label]) -> list[Order | tuple[Label, str]]:
        """An order for each row, or the row with what is wrong with it.

        Raises `DesignError` for columns that are no parameters and in no pattern, for patterns that name a
        column which is not there, and for two rows of one name.
        """
        columns = dict.fromkeys(name for row in rows for name in row.cells)
        self._check_columns(list(columns))
        width = len(str(len(rows)))
        found: list[Order | tuple[Label, str]] = []
        taken: dict[str, int] = {}
        for row in rows:
            cells = {**dict.fromkeys(columns, ""), NUMBER: f"{row.number:0{width}}", **row.cells}
            name = _filled(self.pattern or ("{name}" if row.cells.get(NAME) else "{row}"), cells)
            fault = row.fault or _fault(name)
            if fault:
                found.append((row, fault))
                continue
            if (other := taken.setdefault(name.casefold(), row.number)) != row.number:
                raise DesignError(
                    f"rows {other} and {row.number} are both named {name!r}: give each its own name"
                )
            found.append(self._order(row, name, cells))
        return found

    def _order(self, row: Label, name: str, cells: Mapping[str, str]) -> Order:
        known = {parameter.name for parameter in self.template.parameters}
        own = {name: cell for name, cell in row.cells.items() if name in known}
        hidden = set(SOURCES) if own.keys() & set(SOURCES) else set[str]()
        shared = {k: _filled(value, cells) for k, value in self.shared.items() if k not in hidden}
        values = {**shared, **own}
        outputs = tuple((self.folder / f"{name}{suffix}").as_posix() for suffix in self.suffixes)
        return Order(row.number, name, str(self.template.path), values, outputs, self.timeout_s)

    def _check_columns(self, columns: Sequence[str]) -> None:
        used = {
            field for pattern in (self.pattern or "", *self.shared.values()) for field in _fields(pattern)
        }
        if missing := sorted(used - {*columns, NUMBER}):
            raise DesignError(f"{{{missing[0]}}} names no column: the table has {', '.join(columns)}")
        for name in columns:
            if name not in used and name != NAME:
                self.template.parameter(name)


def suffixes(files: str) -> tuple[str, ...]:
    """Suffixes of the files of each row; the certificate is always one of them.

    >>> suffixes("stl, step")
    ('.stl', '.step', '.json')
    """
    named = [f".{name.strip().lower().removeprefix('.')}" for name in files.split(",") if name.strip()]
    for suffix in named:
        module_of(f"part{suffix}")
    return tuple(dict.fromkeys([*named, ".json"]))


def _fields(pattern: str) -> list[str]:
    """The columns that a pattern names. Raises `DesignError` for a pattern that is none."""
    try:
        return [field for _, field, _, _ in Formatter().parse(pattern) if field is not None]
    except ValueError as error:
        raise DesignError(f"pattern {pattern!r}: {error}: write {{column}}, and {{{{ for a brace") from error


def _filled(pattern: str, cells: Mapping[str, str]) -> str:
    """The pattern with the cells in it; no formats, attributes or indices."""
    parts = Formatter().parse(pattern)
    return "".join(text + ("" if field is None else cells[field]) for text, field, _, _ in parts)


def _fault(name: str) -> str | None:
    """What keeps this from being the name of a file on every system."""
    if not name.strip(" .") or name != name.strip() or name.endswith("."):
        return f"name {name!r} is empty, or begins or ends with a blank or a full stop"
    if forbidden := _FORBIDDEN.search(name):
        return f"name {name!r} holds {forbidden[0]!r}, which no file may: leave it out"
    if _DEVICES.fullmatch(name):
        return f"name {name!r} is a device on Windows: name it otherwise"
    if len(name) > MOST_NAME:
        return f"name {name[:20]!r}… has {len(name)} letters, limit {MOST_NAME}: shorten it"
    return None
