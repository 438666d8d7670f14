"""What a run leaves on the disk while it works, so that whoever survives it can clear it.

Each run keeps a journal: a file named by its process number in a folder of this user's, one path a line. A
run that is killed cannot clear its scratch folders; its supervisor does (`cli.entry`), or the next run does
(`sweep`).
"""

from __future__ import annotations

import fcntl
import os
import shutil
import stat
import tempfile
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path

PREFIX = ".perfqr-"  # of scratch folders: only folders of that name are ever cleared


def note(path: Path) -> None:
    """Write a path into this run's journal, before it is made."""
    with _journal(os.getpid()).open("a", encoding="utf-8") as journal:
        journal.write(f"{path.absolute()}\n")


@contextmanager
def publishing() -> Generator[None]:
    """While finished files are renamed into their places: `settle` waits for the end, so a set is whole."""
    with _journal(os.getpid()).open("a", encoding="utf-8") as journal:
        fcntl.flock(journal, fcntl.LOCK_EX)
        yield


def clear(process: int) -> None:
    """Remove what a process left that has ended: scratch folders, and folders it made that are empty."""
    journal = _journal(process)
    with suppress(OSError):
        for line in reversed(journal.read_text(encoding="utf-8").splitlines()):
            path = Path(line)
            if path.name.startswith(PREFIX):
                shutil.rmtree(path, ignore_errors=True)
            else:
                with suppress(OSError):  # not empty, or gone: somebody else's by now
                    path.rmdir()
    journal.unlink(missing_ok=True)


def settle(process: int) -> None:
    """Wait until a process is not in the middle of `publishing`."""
    with suppress(FileNotFoundError), _journal(process).open("rb") as journal:
        fcntl.flock(journal, fcntl.LOCK_EX)


def sweep() -> None:
    """Clear what processes left that are no more."""
    for journal in _folder().glob("[0-9]*"):
        process = int(journal.name)
        if not _alive(process):
            clear(process)


def _alive(process: int) -> bool:
    """Whether a process runs; one that ended and was not waited for yet does not."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:  # somebody else's
        return True
    status = Path(f"/proc/{process}/stat")  # pid (name) state …, proc(5); Linux only
    return not status.exists() or status.read_text().rpartition(")")[2].split()[0] not in "ZX"


def _journal(process: int) -> Path:
    return _folder() / f"{process}"


def _folder() -> Path:
    """This user's own folder of journals; one that belongs to somebody else is not trusted."""
    folder = Path(tempfile.gettempdir()) / f"perfqr-{os.getuid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    found = folder.lstat()
    if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid():
        return Path(tempfile.mkdtemp(prefix=f"perfqr-{os.getuid()}-"))
    return folder
