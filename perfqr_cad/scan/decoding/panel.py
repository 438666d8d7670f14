"""A panel of decoders that cannot hurt us: each call runs in a worker process under a limit of computing.

A worker that crashes or never ends is a miss for the decoder that held it, and is counted; it is replaced and
the work goes on.
"""

from __future__ import annotations

import atexit
import queue
import threading
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from types import TracebackType

import numpy as np

from perfqr_cad.errors import AnalysisError
from perfqr_cad.isolated import IsolationError, Limits, OutOfTime, Worker
from perfqr_cad.scan.decoding import decoders
from perfqr_cad.scan.decoding.decoders import Gray
from perfqr_cad.scan.decoding.worker import Readers

# The paper counts a decoding as successful within 2 s (§6). Here they are seconds of computing: what runs
# beside the panel changes no result.
LIMITS = Limits(cpu_s=2.0)
JOB = f"{Readers.__module__}:{Readers.__name__}"
Reading = dict[str, tuple[bytes, ...]]
Source = Gray | Callable[[], Gray]  # a picture, or what makes it when its turn comes


@dataclass(frozen=True)
class Losses:
    """How often an engine met its limit, and how often it crashed, by name: views that count as missed."""

    timeouts: dict[str, int] = field(default_factory=dict[str, int])
    crashes: dict[str, int] = field(default_factory=dict[str, int])

    def since(self, before: Losses) -> Losses:
        """Those that have come since."""
        return Losses(
            dict(Counter(self.timeouts) - Counter(before.timeouts)),
            dict(Counter(self.crashes) - Counter(before.crashes)),
        )

    def sentences(self) -> tuple[str, ...]:
        """Each as a line for people."""
        return (
            *(
                f"{name} met its limit of {LIMITS.cpu_s:g} s of computing {count} times: counted as misses"
                for name, count in self.timeouts.items()
            ),
            *(f"{name} crashed {count} times: counted as misses" for name, count in self.crashes.items()),
        )


def _gray(source: Source) -> Gray:
    image = source() if callable(source) else source
    if image.dtype != np.uint8 or image.ndim != 2:
        raise ValueError(f"the panel reads gray uint8 images, not {image.dtype} of shape {image.shape}")
    return np.ascontiguousarray(image)


class Panel:
    """Decoders by name behind worker processes. Use it as a context manager, or call `close`."""

    def __init__(
        self,
        names: Sequence[str] | None = None,
        *,
        workers: int = 2,
        job: str = JOB,
        limits: Limits = LIMITS,
    ) -> None:
        """`names` defaults to every engine present. AnalysisError if a name is unknown or absent."""
        present = decoders.available()
        missing = [name for name in names or () if name not in present]
        if missing:
            raise AnalysisError(f"decoder {missing[0]} is not available: choose from {', '.join(present)}")
        self._wanted = tuple(names) if names is not None else present
        self._workers = [Worker(job, *self._wanted, limits=limits) for _ in range(workers)]
        self._timeouts, self._crashes = Counter[str](), Counter[str]()
        for process in self._workers:
            process.start()

    @cached_property
    def left_out(self) -> dict[str, str]:
        """Why engines that were wanted cannot be loaded here, by name. AnalysisError if none can."""
        reasons = _ready(self._workers[0])
        if len(reasons) == len(self._wanted):
            self.close()
            why = "; ".join(f"{name}: {reason}" for name, reason in reasons.items())
            raise AnalysisError(f"none of {len(reasons)} decoders can be loaded ({why}): install one again")
        return reasons

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The engines that read."""
        return tuple(name for name in self._wanted if name not in self.left_out)

    @property
    def losses(self) -> Losses:
        """What has been lost to limits and crashes so far."""
        return Losses(dict(self._timeouts), dict(self._crashes))

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
        ended = threading.Event()
        lock = threading.Lock()
        done = 0

        def work(worker: Worker) -> None:
            nonlocal done
            while not ended.is_set():
                try:
                    index = tasks.get_nowait()
                except queue.Empty:
                    return
                try:
                    image = _gray(images[index])
                    for name in self.names if names is None else names[index]:
                        if not ended.is_set():
                            readings[index][name] = self._ask(worker, name, image)
                except Exception as failure:  # noqa: BLE001  raised again by the caller's thread
                    failures.append(failure)
                    ended.set()
                    return
                with lock:
                    done += 1
                    if progress is not None:
                        progress(done)

        threads = [threading.Thread(target=work, args=(w,)) for w in self._workers[: len(images)]]
        try:
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
        except BaseException:  # an interrupt: no thread may go on without us
            ended.set()
            self.close()
            raise
        if failures:
            raise failures[0]
        return readings

    def _ask(self, worker: Worker, decoder: str, image: Gray) -> tuple[bytes, ...]:
        """Payloads that one decoder reads in one image; () on a miss, a crash and a time-out alike."""
        _ready(worker)
        try:
            payloads = worker.ask({"decoder": decoder}, image).value
        except OutOfTime:
            self._timeouts[decoder] += 1
            return ()
        except IsolationError:
            self._crashes[decoder] += 1
            return ()
        return tuple(bytes.fromhex(payload) for payload in payloads)

    def close(self) -> None:
        """End the worker processes."""
        for process in self._workers:
            process.stop()

    def __enter__(self) -> Panel:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _ready(worker: Worker) -> dict[str, str]:
    """Have a worker started: the engines that it could not load, and why."""
    try:
        return worker.report
    except IsolationError as reason:
        raise AnalysisError(
            f"the decoder process does not start ({reason}): install the package again"
        ) from reason


_shared: dict[tuple[str, ...], Panel] = {}


def shared(names: Sequence[str] | None = None) -> Panel:
    """A panel that is started once and kept for the life of this process: starting costs a second."""
    key = tuple(names) if names is not None else decoders.available()
    if key not in _shared:
        _shared[key] = Panel(key)
        atexit.register(_shared[key].close)
    return _shared[key]
