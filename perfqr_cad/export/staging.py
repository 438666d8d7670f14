"""A folder beside the target in which files are made before they are renamed into place."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path

from perfqr_cad import scratch
from perfqr_cad.errors import DesignError

SHOWN = 200  # letters of a path in a message


@contextmanager
def staged(folder: Path) -> Generator[Path]:
    """A scratch folder inside `folder`; on success its files are moved up, on any error nothing remains.

    Being on the same file system makes each move one atomic rename. A missing folder is made, and removed
    again after an error. Raises `DesignError` where the folder cannot be written to.
    """
    made: list[Path] = []
    try:
        made = [path for path in (folder, *folder.parents) if not path.exists()]
        for path in reversed(made):
            scratch.note(path)
        folder.mkdir(parents=True, exist_ok=True)
        stage = _scratch_in(folder)
        try:
            yield stage
            _publish(stage, folder)
        finally:
            shutil.rmtree(stage, ignore_errors=True)
    except BaseException as error:
        for path in made:
            with suppress(OSError):  # not empty: somebody else has begun to use it
                path.rmdir()
        if isinstance(error, OSError):
            raise _refusal(folder, error) from error
        raise


def check_writable(target: Path) -> None:
    """Raise the `DesignError` that writing this file would, and leave nothing behind."""
    there = next(path for path in target.parents if os.path.exists(path))
    try:
        trial = _scratch_in(there)
        try:
            wanted = trial / target.relative_to(there)
            wanted.parent.mkdir(parents=True, exist_ok=True)
            wanted.touch()  # a name may be too long, or hold what this file system does not take
        finally:
            shutil.rmtree(trial, ignore_errors=True)
    except OSError as error:
        raise _refusal(target, error) from error


def _scratch_in(folder: Path) -> Path:
    path = folder / f"{scratch.PREFIX}{secrets.token_hex(6)}"
    scratch.note(path)
    path.mkdir(mode=0o700)
    return path


def _publish(stage: Path, folder: Path) -> None:
    """Move the set of files up as a whole: after an error the former files are back in their places."""
    files = sorted(stage.iterdir())
    for path in files:
        if (folder / path.name).is_dir():
            raise DesignError(f"{folder / path.name} is a folder: move it, or write elsewhere")
    former = stage / "former"
    former.mkdir()
    with scratch.publishing():
        try:
            for path in files:
                if (folder / path.name).exists():
                    os.link(folder / path.name, former / path.name)
                os.replace(path, folder / path.name)
        except OSError:
            for path in files:
                if (former / path.name).exists():
                    os.replace(former / path.name, folder / path.name)
                elif not path.exists():  # it was moved up, and there was none before
                    (folder / path.name).unlink()
            raise


def _refusal(path: Path, error: OSError) -> DesignError:
    reason = (error.strerror or str(error)).lower()
    named = str(path) if len(str(path)) <= SHOWN else f"{str(path)[:SHOWN]}…"
    return DesignError(f"{named}: cannot write there ({reason}); name a place that can be written to")
