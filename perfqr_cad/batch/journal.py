"""What a batch has done so far, so that the next run of it goes on from there."""

from __future__ import annotations

import json
import os
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

FILE = "batch.jsonl"  # in the batch's folder: one finished row a line


class Journal:
    """Finished rows by name: the key of what was made, and what became of it."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._entries = dict(_entries(path))

    def outcome(self, name: str, key: str) -> dict[str, Any] | None:
        """What became of a row of that name and key; None when none was made."""
        entry = self._entries.get(name)
        return None if entry is None or entry["key"] != key else entry["outcome"]

    @contextmanager
    def writing(self) -> Generator[Journal]:
        """Lines are added at the end, behind what was there; one that was cut short is ended first."""
        self._path.parent.mkdir(parents=True, exist_ok=True)
        with self._path.open("ab") as self._file:
            if self._path.stat().st_size and not self._path.read_bytes().endswith(b"\n"):
                self._file.write(b"\n")
            yield self

    def add(self, name: str, key: str, outcome: dict[str, Any]) -> None:
        """A finished row; it is on the disk when this returns."""
        line = json.dumps({"name": name, "key": key, "outcome": outcome}, ensure_ascii=True, sort_keys=True)
        self._file.write(line.encode() + b"\n")
        self._file.flush()
        os.fsync(self._file.fileno())


def _entries(path: Path) -> Generator[tuple[str, dict[str, Any]]]:
    """Lines that are whole; the last one may have been cut short when its run was killed."""
    if not path.exists():
        return
    for line in path.read_bytes().splitlines():
        try:
            entry = json.loads(line)
            yield str(entry["name"]), {"key": entry["key"], "outcome": dict(entry["outcome"])}
        except (ValueError, KeyError, TypeError):
            continue
