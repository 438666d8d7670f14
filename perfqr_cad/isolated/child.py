"""The other side: a script that `process` starts by its path with `python -I`.

Its one argument is JSON: `job`, `arguments`, `sites` (folders of installed packages), `cpu_s`,
`memory_bytes`, and the file descriptors of the `channel` and of the `lifeline`, a pipe that closes when the
parent ends.
"""

from __future__ import annotations

import fcntl
import importlib
import importlib.util
import json
import os
import resource
import signal
import socket
import sys
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from perfqr_cad.isolated.wire import Message

PACKAGE = Path(__file__).resolve().parents[1]
START_CPU_S = 60.0  # loading every decoder takes 1 s, the solid modeller 2 s
MOST_STDERR_BYTES = 2**20  # and of any other file: none is written here


def main(settings: dict[str, Any]) -> None:
    """Bound this process, prepare the job, and answer until the channel closes."""
    _die_with_parent(settings["lifeline"])
    _limit(resource.RLIMIT_DATA, settings["memory_bytes"])
    _limit(resource.RLIMIT_CORE, 0)
    _limit(resource.RLIMIT_FSIZE, MOST_STDERR_BYTES)
    signal.setitimer(signal.ITIMER_PROF, START_CPU_S)
    sys.path += [site for site in settings["sites"] if site not in sys.path]
    _load(PACKAGE.name, PACKAGE / "__init__.py")  # by its place: no folder of ours is searched for modules
    from perfqr_cad.isolated import wire

    answer, report = _prepared(settings["job"], settings["arguments"])
    signal.setitimer(signal.ITIMER_PROF, 0)
    with socket.socket(fileno=settings["channel"]) as channel:
        _say(channel, wire.Message({"ready": report}))
        while True:
            try:
                request = wire.receive(lambda buffer: _fill(channel, buffer), sys.maxsize)
            except EOFError:
                return
            signal.setitimer(signal.ITIMER_PROF, settings["cpu_s"])  # its signal ends this process
            result = _answered(answer, request)
            signal.setitimer(signal.ITIMER_PROF, 0)
            _say(channel, result)


@contextmanager
def without_files() -> Generator[None]:
    """Within it no file can be opened, whatever a native parser finds in what it reads; for jobs."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (0, hard))  # what is open stays open
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def _die_with_parent(lifeline: int) -> None:
    """Have the kernel end this process, in whatever native code it is, when the lifeline closes."""
    fcntl.fcntl(lifeline, fcntl.F_SETOWN, os.getpid())
    fcntl.fcntl(lifeline, fcntl.F_SETFL, os.O_ASYNC | os.O_NONBLOCK)
    try:
        closed = os.read(lifeline, 1) == b""  # before it was watched
    except BlockingIOError:
        closed = False
    if closed:
        sys.exit(1)


def _limit(what: int, soft: int) -> None:
    hard = resource.getrlimit(what)[1]
    if hard != resource.RLIM_INFINITY:
        soft = min(soft, hard)
    resource.setrlimit(what, (soft, soft))


def _load(name: str, path: Path) -> ModuleType:
    """A module from the file at an absolute path."""
    inside = [str(path.parent)] if path.name == "__init__.py" else None
    spec = importlib.util.spec_from_file_location(name, path, submodule_search_locations=inside)
    if spec is None or spec.loader is None:
        raise ImportError(f"{path} is no Python module")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def _prepared(job: str, arguments: list[Any]) -> tuple[Callable[[Message], Message], Any]:
    """What answers, and what the job reports of its start: an attribute `report` of that, or None."""
    place, _, function = job.partition(":")
    path = Path(place)
    module = _load(path.stem, path) if path.is_absolute() else importlib.import_module(place)
    answer = getattr(module, function)(*arguments)
    return answer, getattr(answer, "report", None)


def _answered(answer: Callable[[Message], Message], request: Message) -> Message:
    """The answer; for an exception its kind and text, under the key `error`."""
    from perfqr_cad.errors import PerfQRError
    from perfqr_cad.isolated.wire import Message

    try:
        found = answer(request)
    except PerfQRError as error:
        return Message({"error": [type(error).__name__, str(error)]})
    except MemoryError:
        return Message({"error": ["MemoryError", ""]})
    except Exception as error:  # noqa: BLE001  whatever a parser raises is an answer: it cannot read this
        return Message({"error": ["", f"{type(error).__name__}: {error}"]})
    return Message({"answer": found.value}, found.arrays)


def _say(channel: socket.socket, message: Message) -> None:
    from perfqr_cad.isolated import wire

    wire.send(message, channel.sendall)


def _fill(channel: socket.socket, buffer: memoryview) -> None:
    while buffer:
        count = channel.recv_into(buffer)
        if count == 0:
            raise EOFError
        buffer = buffer[count:]


if __name__ == "__main__":
    main(json.loads(sys.argv[1]))
