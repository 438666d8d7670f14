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


@contextmanager
def staged(folder: Path, *, create: bool = False) -> Generator[Path]:
    """A scratch folder inside `folder`; on success its files are moved up, on any error nothing remains.

    Being on the same file system makes each move one atomic rename. With `create` a missing folder is
    made, and removed again after an error. Raises `DesignError` where the folder cannot be written to.
    """
    made: list[Path] = []
    try:
        if create:
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


def check_writable(folder: Path, *, create: bool = False) -> None:
    """Raise the `DesignError` that `staged` would, and leave nothing behind."""
    there = next(path for path in (folder, *folder.parents) if path.exists()) if create else folder
    try:
        Path(tempfile.mkdtemp(prefix=_PREFIX, dir=there)).rmdir()
    except OSError as error:
        raise _refusal(folder, error) from error


def _publish(stage: Path, folder: Path) -> None:
    files = sorted(stage.iterdir())
    for path in files:
        if (folder / path.name).is_dir():
            raise DesignError(f"{folder / path.name} is a folder: move it, or write elsewhere")
    for path in files:
        os.replace(path, folder / path.name)


def _refusal(folder: Path, error: OSError) -> DesignError:
    reason = (error.strerror or str(error)).lower()
    return DesignError(f"{folder}: cannot write there ({reason}); name a folder that can be written to")
