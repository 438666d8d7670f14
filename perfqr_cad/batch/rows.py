"""A table of labels: CSV as spreadsheets write it, or a plain list with a text a line."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from perfqr_cad.bounded import MIB, read_text
from perfqr_cad.errors import DesignError

Item = TypeVar("Item")

MOST_BYTES = 64 * MIB
MOST_ROWS = 1_000_000
MOST_CELL = 20_000  # letters: more than any code, caption or path holds
DELIMITERS = ",;\t"  # spreadsheets of many countries write semicolons


@dataclass(frozen=True)
class Label:
    """One part to be made.

    number  of its line's place in the table, from 1
    cells   what is written by column; empty cells are left out
    fault   what is wrong with the row, None where nothing is
    """

    number: int
    cells: Mapping[str, str]
    fault: str | None = None


def read_table(path: str | Path) -> list[Label]:
    """The rows of a CSV file, whose first line names the columns; blank lines are left out.

    The delimiter is the one of comma, semicolon and tab that parts the first line most often. Raises
    `DesignError` for a file that is no text in UTF-8 (with or without a byte order mark), without rows, with
    unnamed or equal columns, or with a cell of more than `MOST_CELL` letters.
    """
    text = read_text(path, MOST_BYTES, DesignError, "a table in CSV")
    head = text.partition("\n")[0]
    delimiter = max(DELIMITERS, key=head.count)
    before = csv.field_size_limit(MOST_CELL)
    try:
        lines = [line for line in csv.reader(io.StringIO(text, newline=""), delimiter=delimiter) if any(line)]
    except csv.Error as error:
        raise DesignError(
            f"{path} cannot be read as a table ({error}): a cell holds {MOST_CELL:,} letters"
        ) from error
    finally:
        csv.field_size_limit(before)
    columns = _columns(path, lines)
    return [_row(number, columns, line) for number, line in enumerate(_rows(path, lines[1:]), 1)]


def read_lines(path: str | Path) -> list[Label]:
    """A text a line; blank lines are left out."""
    lines = read_text(path, MOST_BYTES, DesignError, "a list with a text a line").splitlines()
    return [
        Label(number, {"text": line})
        for number, line in enumerate(_rows(path, list(filter(str.strip, lines))), 1)
    ]


def _rows(path: str | Path, rows: list[Item]) -> list[Item]:
    if not 0 < len(rows) <= MOST_ROWS:
        raise DesignError(f"{path} has {len(rows):,} rows: give 1 to {MOST_ROWS:,}")
    return rows


def _columns(path: str | Path, lines: list[list[str]]) -> list[str]:
    columns = [name.strip() for name in lines[0]] if lines else []
    if not columns or "" in columns:
        raise DesignError(f"{path}: the first line must name every column: text;size;caption, say")
    twice = [name for name, count in Counter(columns).items() if count > 1]
    if twice:
        raise DesignError(f"{path}: column {twice[0]!r} is there twice: rename one of them")
    return columns


def _row(number: int, columns: list[str], line: list[str]) -> Label:
    cells = {name: cell for name, cell in zip(columns, line, strict=False) if cell}
    if len(line) > len(columns):
        return Label(
            number, cells, f"has {len(line)} cells, the first line names {len(columns)}: quote its cells"
        )
    return Label(number, cells)
