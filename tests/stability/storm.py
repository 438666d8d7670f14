"""A storm of random requests: `python -m tests.stability.storm --seeds 0:200 [--out FOLDER]`.

Each goes through the command line or through Python. What is made is judged from outside, what is refused
must be one true line, and a remedy that it names must help. Prints a tally; FOLDER/faults.txt gets a short
reproducer of each fault.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import traceback
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from perfqr_cad import make
from perfqr_cad.errors import NotHeldError, PerfQRError

from .drawn import Asked, draw
from .judges import FILES, TRIED, Outcome, faults, remedies

MOST_STEPS = 4  # remedies one after the other, before it counts as a loop
MOST_SHRINKS = 12  # runs that may be spent on one reproducer
BAD_INPUT, NOT_HELD, TRACEBACK = 2, 3, 1
ROOT = Path(__file__).parents[2]


@dataclass(frozen=True)
class Fault:
    """Something that went wrong, and the request that does it."""

    what: str
    asked: Asked

    @property
    def kind(self) -> str:
        """Without figures and names: what a shorter request must still do."""
        return re.sub(r"[\d.]+|'[^']*'|\{.*\}", "…", self.what)[:60]


@dataclass(frozen=True)
class Result:
    """What one seed came to."""

    seed: int
    outcome: Outcome
    faults: tuple[Fault, ...]


def run(seed: int, folder: Path) -> Result:
    """Draw the request of a seed, send it, judge what comes back and follow the remedies that it names."""
    asked = draw(seed, folder / "pictures")
    outcome = send(asked, folder)
    found = [Fault(what, asked) for what in faults(asked, outcome)]
    if not outcome.made and not found:
        found += _loops(asked, outcome, folder)
    return Result(seed, outcome, tuple(found))


def send(asked: Asked, folder: Path) -> Outcome:
    """One request through its door, with its files in a new folder."""
    place = Path(tempfile.mkdtemp(prefix=f"{asked.seed}-", dir=folder))
    outputs = [str(place / name) for name in FILES]
    return _command(asked, outputs, place) if asked.command else _python(asked, outputs, place)


def shortest(fault: Fault, folder: Path) -> Fault:
    """The fault with as few settings as `MOST_SHRINKS` runs show to be needed."""
    for field in list(fault.asked.settings)[:MOST_SHRINKS]:
        fewer = fault.asked.without(field)
        outcome = send(fewer, folder)
        found = [Fault(what, fewer) for what in faults(fewer, outcome)]
        if not outcome.made and not found:
            found += _loops(fewer, outcome, folder)
        fault = next((one for one in found if one.kind == fault.kind), fault)
    return fault


def _loops(asked: Asked, refusal: Outcome, folder: Path) -> Iterator[Fault]:
    """Remedies that do not help, or lead to a fault."""
    for remedy in remedies(refusal.said):
        changed, said = asked, refusal.said
        seen = {said}
        for _ in range(MOST_STEPS):
            tried = TRIED in said
            changed = changed.changed(remedy)
            after = send(changed, folder)
            yield from (
                Fault(f"after the remedy {remedy}: {what}", changed) for what in faults(changed, after)
            )
            if after.made:
                break
            if tried or after.said in seen:
                yield Fault(f"remedy {remedy} of {said!r} does not help: {after.said!r}", asked)
                break
            said = after.said
            seen.add(said)
            if not (further := remedies(said)):
                break
            remedy = further[0]
        else:
            yield Fault(f"after {MOST_STEPS} remedies still {said!r}", asked)


def _command(asked: Asked, outputs: list[str], place: Path) -> Outcome:
    path = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        [sys.executable, "-m", "perfqr_cad", *asked.arguments(outputs)],
        capture_output=True,
        env=os.environ | {"PYTHONPATH": path},
        check=False,
    )
    return Outcome(done.returncode, done.stderr.decode(), place)


def _python(asked: Asked, outputs: list[str], place: Path) -> Outcome:
    try:
        make(**asked.settings).written(outputs)
    except PerfQRError as error:
        return Outcome(NOT_HELD if isinstance(error, NotHeldError) else BAD_INPUT, f"error: {error}", place)
    except Exception:  # noqa: BLE001  # whatever it is, it is a fault that the tally tells
        return Outcome(TRACEBACK, traceback.format_exc(), place)
    return Outcome(0, "", place)


def _kind(outcome: Outcome) -> str:
    """A refusal without its figures and names."""
    said = outcome.said.removeprefix("error: ").strip()
    return re.sub(r"'[^']*'|-?\d[\d.,]*", "…", said)[:70]


def main(arguments: list[str] | None = None) -> int:
    """Run the seeds, print the tally; exit code 1 where there are faults."""
    parser = argparse.ArgumentParser(prog="python -m tests.stability.storm", description=__doc__)
    parser.add_argument("--seeds", default="0:200", help="FIRST:BEHIND_LAST")
    parser.add_argument("--out", type=Path, default=Path("out/storm"))
    asked = parser.parse_args(arguments)
    first, behind = (int(number) for number in asked.seeds.split(":"))
    asked.out.mkdir(parents=True, exist_ok=True)
    tally: Counter[str] = Counter()
    with (asked.out / "faults.txt").open("w", encoding="utf-8") as file:
        for seed in range(first, behind):
            with tempfile.TemporaryDirectory() as folder:
                result = run(seed, Path(folder))
                tally["made" if result.outcome.made else f"refused: {_kind(result.outcome)}"] += 1
                said = "made" if result.outcome.made else result.outcome.said.strip()
                print(f"{seed} {said}", flush=True)
                for fault in result.faults:
                    tally["fault"] += 1
                    short = shortest(fault, Path(folder))
                    text = f"seed {seed}: {short.what}\n    {short.asked.line()}\n"
                    print(text, flush=True)
                    file.write(text)
                    file.flush()
    for what, count in tally.most_common():
        print(f"{count:5} {what}")
    return 1 if tally["fault"] else 0


if __name__ == "__main__":
    sys.exit(main())
