"""A folder beside the target in which files are made before they are renamed into place."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path

from perfqr_cad.errors import DesignError

_PREFIX = ".perfqr-"
_SHOWN = 200  # letters of a path in a message


@contextmanager
def staged(folder: Path) -> Generator[Path]:
    """A scratch folder inside `folder`; on success its files are moved up, on any error nothing remains.

    Being on the same file system makes each move one atomic rename. A missing folder is made, and removed
    again after an error. Raises `DesignError` where the folder cannot be written to.
    """
    made: list[Path] = []
    try:
        made = [path for path in (folder, *folder.parents) if not path.exists()]
        folder.mkdir(parents=True, exist_ok=True)
        stage = Path(tempfile.mkdtemp(prefix=_PREFIX, dir=folder))
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
        with tempfile.TemporaryDirectory(prefix=_PREFIX, dir=there) as scratch:
            wanted = Path(scratch) / target.relative_to(there)
            wanted.parent.mkdir(parents=True, exist_ok=True)
            wanted.touch()  # a name may be too long, or hold what this file system does not take
    except OSError as error:
        raise _refusal(target, error) from error


def _publish(stage: Path, folder: Path) -> None:
    files = sorted(stage.iterdir())
    for path in files:
        if (folder / path.name).is_dir():
            raise DesignError(f"{folder / path.name} is a folder: move it, or write elsewhere")
    for path in files:
        os.replace(path, folder / path.name)


def _refusal(path: Path, error: OSError) -> DesignError:
    reason = (error.strerror or str(error)).lower()
    return DesignError(
        f"{shortened(path)}: cannot write there ({reason}); name a place that can be written to"
    )


def shortened(path: Path) -> str:
    """A path as a message shows it."""
    return str(path) if len(str(path)) <= _SHOWN else f"{str(path)[:_SHOWN]}…"
