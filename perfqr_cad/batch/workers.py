"""Rows handed to workers, and the summary of what became of them."""

from __future__ import annotations

import csv
import io
import multiprocessing
import os
import threading
import time
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from functools import partial
from pathlib import Path
from queue import SimpleQueue

from perfqr_cad.batch.journal import FILE, Journal
from perfqr_cad.batch.making import Outcome, is_whole, make_row
from perfqr_cad.batch.order import Order, Plan
from perfqr_cad.batch.rows import Label
from perfqr_cad.errors import DesignError
from perfqr_cad.export.staging import staged

SUMMARY = "batch.csv"  # in the batch's folder
WATCH_S = 1.0  # between two looks of a worker at whether its batch goes on
ROWS_A_WORKER = 100  # then it is replaced: what native code leaks does not add up

Work = Callable[[Order], Outcome]
Told = Callable[[Outcome], None]


@dataclass(frozen=True)
class Summary:
    """What became of all rows, in their order, and the file that says so."""

    outcomes: tuple[Outcome, ...]
    path: Path

    @property
    def complete(self) -> bool:
        """Whether every row's files are there."""
        return all(outcome.is_there for outcome in self.outcomes)

    @property
    def words(self) -> str:
        """Rows by what became of them."""
        counts = Counter(outcome.status for outcome in self.outcomes)
        return ", ".join(f"{count} {status}" for status, count in counts.items())


def run(
    plan: Plan,
    rows: Sequence[Label],
    *,
    jobs: int = 1,
    scheduler: str | None = None,
    told: Told = lambda _: None,
) -> Summary:
    """Make every row that is not there yet.

    jobs       processes of this machine
    scheduler  address of a Dask scheduler instead, whose workers see the same folder
    told       hears of every row as it is finished

    A row that cannot be made stops no other. Raises `DesignError` for what concerns the table as a whole.
    """
    orders = plan.orders(rows)
    source = plan.template.path.read_bytes()
    journal = Journal(plan.folder / FILE)
    done: list[Outcome] = [Outcome(row.number, "", "refused", note) for row, note in _faulty(orders)]
    waiting: list[Order] = []
    for order in (order for order in orders if isinstance(order, Order)):
        before = journal.outcome(order.name, order.key(source))
        if before is not None and is_whole(order):
            done.append(replace(Outcome(**before), number=order.number, status="kept", note=""))
        else:
            waiting.append(order)
    for outcome in done:
        told(outcome)
    workers = _pool(jobs) if scheduler is None else _cluster(scheduler)
    with journal.writing(), workers as submit:
        for order, outcome in _finished(waiting, submit):
            if outcome.is_there:
                journal.add(order.name, order.key(source), outcome.as_dict())
            done.append(outcome)
            told(outcome)
    return _summed_up(sorted(done, key=lambda outcome: outcome.number), plan.folder)


def _faulty(orders: Iterable[Order | tuple[Label, str]]) -> list[tuple[Label, str]]:
    return [one for one in orders if not isinstance(one, Order)]


def _finished(
    orders: Sequence[Order], submit: Callable[[Order], Future[Outcome]]
) -> Generator[tuple[Order, Outcome]]:
    """Each order with its outcome, as they come."""
    futures = {submit(order): order for order in orders}
    for future in as_completed(futures):
        order, error = futures[future], future.exception()
        if error is None:
            yield order, future.result()
        else:
            note = " ".join(f"{type(error).__name__}: {error}".split())
            yield order, Outcome(order.number, order.name, "failed", note)


@contextmanager
def _pool(jobs: int) -> Generator[Callable[[Order], Future[Outcome]]]:
    """Threads that each hold a process: a crash of native code ends one row and one process."""
    if jobs < 1:
        raise DesignError(f"{jobs} jobs make nothing: give --jobs 1 or more")
    idle: SimpleQueue[_Worker] = SimpleQueue()
    for _ in range(jobs):
        idle.put(_Worker())

    def work(order: Order) -> Outcome:
        worker = idle.get()
        try:
            return worker(order)
        finally:
            idle.put(worker)

    with ThreadPoolExecutor(jobs) as threads:
        try:
            yield partial(threads.submit, work)
        finally:
            threads.shutdown(cancel_futures=True)
            for _ in range(jobs):
                idle.get().close()


class _Worker:
    """A process that makes rows, begun anew when it has died or has made many."""

    def __init__(self) -> None:
        self._executor: ProcessPoolExecutor | None = None
        self._rows = 0

    def __call__(self, order: Order) -> Outcome:
        if self._rows == ROWS_A_WORKER:
            self.close()
        if self._executor is None:
            fresh = multiprocessing.get_context("spawn")  # no threads or handles of this process
            self._executor = ProcessPoolExecutor(1, fresh, _end_with_parent, (os.getpid(),))
            self._rows = 0
        self._rows += 1
        try:
            return self._executor.submit(make_row, order).result()
        except BrokenProcessPool:
            self._executor = None
            note = "native code ended the process, or the system did for want of memory"
            return Outcome(order.number, order.name, "failed", note)

    def close(self) -> None:
        if self._executor is not None:
            self._executor.shutdown()
            self._executor = None


def _end_with_parent(parent: int) -> None:
    """Let this process end when the one that began it is killed: nobody would hear of its rows."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(WATCH_S)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


@contextmanager
def _cluster(address: str) -> Generator[Callable[[Order], Future[Outcome]]]:
    """The workers of a Dask cluster, through its executor for `concurrent.futures`."""
    try:
        from distributed import Client
    except ImportError as error:
        raise DesignError("--scheduler needs Dask: pip install 'perfqr-cad[cluster]'") from error
    try:
        client = Client(address, timeout="10s")
    except (OSError, ValueError) as error:
        raise DesignError(
            f"no Dask scheduler answers at {address!r}: name one, as tcp://host:8786"
        ) from error
    with client, client.get_executor(pure=False) as executor:
        yield partial(executor.submit, make_row)


def _summed_up(outcomes: Sequence[Outcome], folder: Path) -> Summary:
    """The summary, written as a table."""
    table = io.StringIO(newline="")
    columns = [field.name for field in fields(Outcome)]
    writer = csv.DictWriter(table, columns)
    writer.writeheader()
    writer.writerows(outcome.as_dict() for outcome in outcomes)
    with staged(folder) as stage:
        (stage / SUMMARY).write_text(table.getvalue(), encoding="utf-8-sig", newline="")
    return Summary(tuple(outcomes), folder / SUMMARY)
