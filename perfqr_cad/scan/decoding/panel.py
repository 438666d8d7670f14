"""A panel of decoders that cannot hurt us: each call runs in a worker process under a time limit.

A worker that crashes or hangs is a miss for the decoder that held it; it is replaced and the work goes on.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Generator, Sequence
from types import TracebackType

import numpy as np

from perfqr_cad.errors import AnalysisError
from perfqr_cad.scan.decoding import decoders
from perfqr_cad.scan.decoding.decoders import Gray

# The paper counts a decoding as successful within 2 s (§6).
TIME_LIMIT_S = 2.0
START_LIMIT_S = 60.0  # loading every engine on a busy machine; a worker that needs longer is broken
Reading = dict[str, tuple[bytes, ...]]
Source = Gray | Callable[[], Gray]  # a picture, or what makes it when its turn comes


class Worker:
    """One decoder process. `ask` returns () on a miss, a crash and a time-out alike."""

    def __init__(
        self, names: Sequence[str], time_limit_s: float, command: Sequence[str] | None = None
    ) -> None:
        self._command = list(command or [sys.executable, "-m", "perfqr_cad.scan.decoding.worker", *names])
        self._time_limit_s = time_limit_s
        self._process: subprocess.Popen[bytes] | None = None

    def ask(self, decoder: str, image: Gray) -> tuple[bytes, ...]:
        """Payloads that one decoder reads in one image."""
        header = {"decoder": decoder, "height": image.shape[0], "width": image.shape[1]}
        request = json.dumps(header).encode() + b"\n" + image.tobytes()
        answer = _exchange(self._running(), request, self._time_limit_s)
        if not answer:
            self.stop()
            return ()
        return tuple(bytes.fromhex(payload) for payload in json.loads(answer))

    def _running(self) -> subprocess.Popen[bytes]:
        if self._process is None:
            pipe = subprocess.PIPE
            self._process = subprocess.Popen(
                self._command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, start_new_session=True
            )
            if _exchange(self._process, b"", START_LIMIT_S) != b"ready\n":
                self.stop()
                raise AnalysisError(
                    f"the decoder process did not start within {START_LIMIT_S:g} s: "
                    "check that zxing-cpp, pyzbar (with the zbar library) and OpenCV import"
                )
        return self._process

    def stop(self) -> None:
        """End the process, whatever it is doing."""
        if self._process is None:
            return
        _kill(self._process)
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                with (
                    _broken_pipes_are_errors(),
                    contextlib.suppress(BrokenPipeError),
                ):  # unsent bytes of a request that was cut short
                    pipe.close()
        self._process = None


def _exchange(process: subprocess.Popen[bytes], request: bytes, limit_s: float) -> bytes:
    """Send a request and wait for a line; empty when the process ends or its time is over."""
    assert process.stdin is not None
    assert process.stdout is not None
    watchdog = threading.Timer(limit_s, _kill, [process])
    watchdog.start()
    try:
        with _broken_pipes_are_errors():
            process.stdin.write(request)
            process.stdin.flush()
        return process.stdout.readline()
    except BrokenPipeError:
        return b""
    finally:
        watchdog.cancel()


@contextlib.contextmanager
def _broken_pipes_are_errors() -> Generator[None]:
    """The solid modeller resets SIGPIPE; its default would end us when a decoder dies mid-request."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGPIPE})
    try:
        yield
    finally:
        signal.sigtimedwait({signal.SIGPIPE}, 0)
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _kill(process: subprocess.Popen[bytes]) -> None:
    """End a process and whatever it started (Node.js)."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)


def _gray(source: Source) -> Gray:
    image = source() if callable(source) else source
    if image.dtype != np.uint8 or image.ndim != 2:
        raise ValueError(f"the panel reads gray uint8 images, not {image.dtype} of shape {image.shape}")
    return np.ascontiguousarray(image)


class Panel:
    """Decoders by name behind worker processes. Use it as a context manager, or call `close`."""

    def __init__(
        self, names: Sequence[str] | None = None, *, time_limit_s: float = TIME_LIMIT_S, workers: int = 2
    ) -> None:
        """`names` defaults to every engine present. AnalysisError if a name is unknown or absent."""
        present = decoders.available()
        missing = [name for name in names or () if name not in present]
        if missing:
            raise AnalysisError(f"decoder {missing[0]} is not available: choose from {', '.join(present)}")
        self.names = tuple(names) if names is not None else present
        self._workers = [Worker(self.names, time_limit_s) for _ in range(workers)]

    def read(self, image: Gray) -> Reading:
        """What each decoder reads in one image (H, W) uint8."""
        return self.read_all([image])[0]

    def read_all(
        self,
        images: Sequence[Source],
        *,
        names: Sequence[Sequence[str]] | None = None,
        progress: Callable[[int], None] | None = None,
    ) -> list[Reading]:
        """What each decoder reads in each image; `progress(n)` is told how many images are done.

        `names` says which decoders see which image; all of them by default. An image may be given as a
        function, which is called in the thread that needs it: pictures are then made while others are read.
        """
        tasks: queue.SimpleQueue[int] = queue.SimpleQueue()
        for index in range(len(images)):
            tasks.put(index)
        readings: list[Reading] = [{} for _ in images]
        failures: list[Exception] = []
        lock = threading.Lock()
        done = 0

        def work(worker: Worker) -> None:
            nonlocal done
            while not failures:
                try:
                    index = tasks.get_nowait()
                except queue.Empty:
                    return
                asked = self.names if names is None else names[index]
                try:
                    image = _gray(images[index])
                    readings[index] = {name: worker.ask(name, image) for name in asked}
                except Exception as failure:  # noqa: BLE001  raised again by the caller's thread
                    failures.append(failure)
                    return
                with lock:
                    done += 1
                    if progress is not None:
                        progress(done)

        threads = [threading.Thread(target=work, args=(w,)) for w in self._workers[: len(images)]]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        if failures:
            raise failures[0]
        return readings

    def close(self) -> None:
        """End the worker processes."""
        for worker in self._workers:
            worker.stop()

    def __enter__(self) -> Panel:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


_shared: dict[tuple[str, ...], Panel] = {}


def shared(names: Sequence[str] | None = None) -> Panel:
    """A panel that is started once and kept for the life of this process: starting costs a second."""
    key = tuple(names) if names is not None else decoders.available()
    if key not in _shared:
        _shared[key] = Panel(key)
        atexit.register(_shared[key].close)
    return _shared[key]
