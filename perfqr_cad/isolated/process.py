"""A running child process and what connects us: a channel both ways, a lifeline, its standard error."""

from __future__ import annotations

import contextlib
import json
import os
import resource
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

CHILD = Path(__file__).resolve().with_name("child.py")
LOOK_S = 1.0  # how often a silent process is looked at
STALL_S = 60.0  # a process that has not worked at all for so long waits for what never comes
NO_SIGNAL = getattr(socket, "MSG_NOSIGNAL", 0)  # the solid modeller resets SIGPIPE, which would end us
# Native libraries start as many threads as there are cores, for work that is over in milliseconds.
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
MAX_WORDS = 160  # letters of what a process said last


@dataclass
class Process:
    """A child and our ends of what connects us.

    ready       whether it has said that it is
    peak_bytes  the most memory it had, once it has ended; 0 if that was less than this process had before
    """

    child: subprocess.Popen[bytes]
    channel: socket.socket
    lifeline: int
    stderr: IO[bytes]
    owner: int = field(default_factory=os.getpid)
    ready: bool = False
    peak_bytes: int = 0
    before: int = field(default_factory=lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)

    @staticmethod
    def started(settings: dict[str, Any]) -> Process:
        """Start `child` with these settings, without waiting for it."""
        ours, theirs = socket.socketpair()
        ours.settimeout(LOOK_S)
        alive, lifeline = os.pipe()
        stderr = tempfile.TemporaryFile()  # noqa: SIM115  closed with the process
        settings = settings | {"sites": _installed(), "channel": theirs.fileno(), "lifeline": alive}
        try:
            child = subprocess.Popen(
                [sys.executable, "-I", str(CHILD), json.dumps(settings)],
                cwd="/",
                env=os.environ | ONE_THREAD,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=stderr,
                pass_fds=(theirs.fileno(), alive),
                start_new_session=True,  # an interrupt at the keyboard is ours to handle
            )
        finally:
            theirs.close()
            os.close(alive)
        return Process(child, ours, lifeline, stderr)

    def write(self, data: bytes | memoryview) -> None:
        """Send all of it. OSError when the process has ended, TimeoutError when it does not listen."""
        rest, patience = memoryview(data), _Patience(self.child.pid)
        while rest:
            try:
                rest = rest[self.channel.send(rest, NO_SIGNAL) :]
            except TimeoutError:
                patience.require_work()

    def fill(self, buffer: memoryview) -> None:
        """Fill a buffer with what comes. EOFError when the process has ended, TimeoutError when it waits."""
        patience = _Patience(self.child.pid)
        while buffer:
            try:
                count = self.channel.recv_into(buffer)
            except TimeoutError:
                patience.require_work()
                continue
            if count == 0:
                raise EOFError
            buffer = buffer[count:]

    def exit_code(self) -> int:
        """How it ended, once its end of the channel is closed; below 0: by which signal."""
        if self.child.returncode is None:
            timer = threading.Timer(LOOK_S, self.kill)  # it closed the channel and goes on
            timer.start()
            _, status, usage = os.wait4(self.child.pid, 0)
            timer.cancel()
            # Before it was another program it was a copy of this one, which the system counts.
            self.peak_bytes = _in_bytes(usage.ru_maxrss) if usage.ru_maxrss > self.before else 0
            self.child.returncode = os.waitstatus_to_exitcode(status)
        return self.child.returncode

    def kill(self) -> None:
        """End it with whatever it has started."""
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self.child.pid, signal.SIGKILL)

    def end(self) -> None:
        """Kill it and free what it held."""
        self.kill()
        self.child.wait()
        self.close()

    def close(self) -> None:
        """Free our ends, which does not end it in a fork of this process."""
        self.channel.close()
        os.close(self.lifeline)
        self.stderr.close()

    def last_words(self) -> str:
        """The last line that it wrote to its standard error."""
        if self.stderr.closed:
            return ""
        self.stderr.seek(0)
        lines = self.stderr.read().decode(errors="replace").split("\n")
        return next((" ".join(line.split())[:MAX_WORDS] for line in reversed(lines) if line.strip()), "")


class _Patience:
    """How long a process may be silent: as long as it works, and `STALL_S` more."""

    def __init__(self, pid: int) -> None:
        self._pid, self._since, self._worked_s = pid, time.monotonic(), _cpu_s(pid)

    def require_work(self) -> None:
        """TimeoutError if the process has not worked for `STALL_S`."""
        now_s = _cpu_s(self._pid)
        if now_s != self._worked_s:
            self._since, self._worked_s = time.monotonic(), now_s
        elif time.monotonic() - self._since > STALL_S:
            raise TimeoutError


def _installed() -> list[str]:
    """Folders of installed packages on this process's path; the current one and a script's are none."""
    return [site for site in sys.path if Path(site).name in ("site-packages", "dist-packages")]


def _in_bytes(maxrss: int) -> int:
    """Of a figure of getrusage(2)."""
    return maxrss if sys.platform == "darwin" else 1024 * maxrss


def _cpu_s(pid: int) -> float:
    """Seconds that a process has computed; 0 where the system does not say."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")  # utime, stime: proc(5)
