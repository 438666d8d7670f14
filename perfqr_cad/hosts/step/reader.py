"""The parts of a STEP file by name or number, each checked and turned outside out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.mesh_files import require_size
from perfqr_cad.hosts.step.host import Host
from perfqr_cad.isolated import Message
from perfqr_cad.solid.kernel import booleans as kernel
from perfqr_cad.solid.step.envelope import ask
from perfqr_cad.solid.step.reader import parts_of, read_step
from perfqr_cad.solid.step.transfer import StepPart, packed, unpacked

LISTED_NAMES = 12  # names shown in a message before "…"


def read_part(path: str | Path, part: str | int | None = None) -> StepPart:
    """The solid of a STEP file, or that of its parts which is named (or numbered from 1) by `part`; sound.

    Raises `KernelError` for a file that cannot be read, holds no closed body or an invalid one, and
    `DesignError` listing the names when there are several solids and `part` does not choose one.
    """
    (chosen,) = unpacked(ask(f"{__name__}:part_reader", path, part))
    return chosen


def part_reader(name: str, part: str | int | None) -> Callable[[Message], Message]:
    """The job of a process: a file's bytes are answered by its part, meshed."""

    def answer(request: Message) -> Message:
        chosen = _chosen(named(parts_of(request.arrays[0].tobytes(), name)), part, name)
        host = Host(chosen.name, kernel.sound(chosen.shape, chosen.name))
        require_size(host.body.triangles.vertices, name)
        return packed([replace(chosen, shape=host.shape)])

    return answer


def read_parts(path: str | Path) -> tuple[StepPart, ...]:
    """All solids of a STEP file in file order, equal names numbered so that each can be chosen."""
    return named(read_step(path))


def named(found: Sequence[StepPart]) -> tuple[StepPart, ...]:
    """Parts with names, equal ones numbered."""
    parts = [replace(part, name=part.name or "part") for part in found]
    names = [part.name for part in parts]
    return tuple(
        replace(part, name=f"{part.name} {names[: i + 1].count(part.name)}")
        if names.count(part.name) > 1
        else part
        for i, part in enumerate(parts)
    )


def _chosen(parts: tuple[StepPart, ...], part: str | int | None, file: str) -> StepPart:
    if part is None or part == "":
        if len(parts) == 1:
            return parts[0]
        raise DesignError(f"{file} is an assembly of {len(parts)} solids: choose part={_names(parts)}")
    found = [p for p in parts if p.name == str(part)]
    if not found and str(part).isdigit() and 1 <= int(part) <= len(parts):
        found = [parts[int(part) - 1]]
    if len(found) == 1:
        return found[0]
    if found:
        raise DesignError(f"{len(found)} parts are called {part!r}: choose by number, 1 to {len(parts)}")
    raise DesignError(f"no part {part!r} in {file}: choose one of {_names(parts)}")


def _names(parts: tuple[StepPart, ...]) -> str:
    listed = ", ".join(repr(p.name) for p in parts[:LISTED_NAMES])
    return listed + (", …" if len(parts) > LISTED_NAMES else "") + f" (or 1 to {len(parts)})"
