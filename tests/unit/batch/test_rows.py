"""Tables as spreadsheets and people write them."""

from __future__ import annotations

from pathlib import Path

import pytest

from perfqr_cad.batch import read_lines, read_table
from perfqr_cad.batch.rows import MOST_CELL
from perfqr_cad.errors import DesignError


def table(folder: Path, content: str | bytes) -> Path:
    path = folder / "labels.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


@pytest.mark.parametrize(
    "content",
    [
        "text,size\nHELLO,40\n",
        "text;size\r\nHELLO;40\r\n",
        "text\tsize\nHELLO\t40",
        "\ufefftext,size\n\nHELLO,40\n,\n",
        'text,size\n"HELLO","40"\n',
    ],
)
def test_one_row_in_every_dialect(tmp_path: Path, content: str) -> None:
    (row,) = read_table(table(tmp_path, content))
    assert (row.number, dict(row.cells), row.fault) == (1, {"text": "HELLO", "size": "40"}, None)


def test_cells_keep_their_letters(tmp_path: Path) -> None:
    (row,) = read_table(table(tmp_path, 'text,caption\n" 1,50 ","two\nlines"\n'))
    assert dict(row.cells) == {"text": " 1,50 ", "caption": "two\nlines"}


def test_a_row_with_too_many_cells_has_a_fault_of_its_own(tmp_path: Path) -> None:
    first, second = read_table(table(tmp_path, "text\na,b\nc\n"))
    assert first.fault == "has 2 cells, the first line names 1: quote its cells"
    assert second.fault is None


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("", "must name every column"),
        ("text,size\n", "has 0 rows"),
        ("text,,size\na,b,c\n", "must name every column"),
        ("text,size,text\na,b,c\n", "column 'text' is there twice"),
        (f"text\n{'x' * (MOST_CELL + 1)}\n", "a cell holds 20,000 letters"),
        ("text\nGrün\n".encode("cp1252"), "is no text in UTF-8"),
        (b"text\na\x00b\n", None),
    ],
)
def test_faults_of_the_whole_table(tmp_path: Path, content: str | bytes, told: str | None) -> None:
    path = table(tmp_path, content)
    if told is None:  # a NUL is a letter as any other; the payload may hold it
        assert read_table(path)[0].cells["text"] == "a\x00b"
        return
    with pytest.raises(DesignError, match=told):
        read_table(path)


def test_a_plain_list(tmp_path: Path) -> None:
    rows = read_lines(table(tmp_path, "\ufeffone\n\n two \n"))
    assert [dict(row.cells) for row in rows] == [{"text": "one"}, {"text": " two "}]
    with pytest.raises(DesignError, match="has 0 rows"):
        read_lines(table(tmp_path, "\n \n"))
