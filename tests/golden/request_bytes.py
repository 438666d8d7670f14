"""Every byte that twenty requests write: `python tests/golden/request_bytes.py record|check [NUMBER ...]`.

Not part of `make test` (it takes minutes): run `check` after a change that must not show in any file. Figures
of time, and the files' own records, are left out of the certificate before it is hashed. The pictures
and meshes that the requests need are made here, so that a clone has all of them.
"""

from __future__ import annotations

import hashlib
import json
import random
import string
import sys
import tempfile
from pathlib import Path
from typing import Any

from perfqr_cad.cli import main

RECORD = Path(__file__).with_name("request_bytes.json")
FORMATS = ("step", "stl", "3mf", "svg", "dxf", "scad", "glb", "png", "vtu", "html", "json")
UNSTABLE = ("timings_s", "files")  # sections of a certificate that differ between two runs


def requests(folder: Path) -> list[list[str]]:
    """Arguments of `perfqr make`, without outputs: every template, and plates drawn with a seed."""
    plates = [_plate(seed) for seed in range(12)]
    small = ["-D", "quiet=2", "--nozzle", "0.3", "--size", "24", "--level", "L"]
    framed = [
        "Hello",
        "--size",
        "42",
        "--frame",
        "8",
        "--corner-radius",
        "3",
        "--hole",
        "3",
        "--caption",
        "lab 3",
    ]
    return [
        *plates,
        ["--image", str(_picture(folder)), "--size", "115", "--nozzle", "0.35"],
        [
            *framed,
            "--caption",
            "lab 3",
            "--backing",
            "1",
            "--gap",
            "0.5",
            "--colour",
            "yellow",
            "--ground",
            "black",
        ],
        ["LOADS", "--size", "50", "--load", "weight,fingertip=0.02", "--material", "PETG"],
        ["TILT", "--level", "L", "--size", "36", "--scan-tilt", "30"],
        ["A", "-t", "bottle", *small, "-D", "diameter=50", "-D", "thickness=1"],
        ["A", "-t", "sphere", *small, "-D", "diameter=56", "-D", "thickness=1"],
        ["A", "-t", "step-face", *small, "-D", f"solid={_tray(folder)}", "-D", "face=3"],
        ["A", "-t", "mesh", *small, "-D", f"mesh={_mesh(folder)}"],
    ]


def written(arguments: list[str], folder: Path) -> dict[str, str]:
    """SHA-256 of each file that the request writes, or the line of its refusal."""
    folder.mkdir()
    names = [f"part.{suffix}" for suffix in FORMATS]
    outputs = [word for name in names for word in ("-o", str(folder / name))]
    try:
        main(["make", *arguments, *outputs])
    except SystemExit as end:
        if end.code:
            return {"exit": str(end.code)}
    return {
        name: hashlib.sha256(_stable(folder / name)).hexdigest() for name in names if (folder / name).exists()
    }


def _stable(path: Path) -> bytes:
    if path.suffix != ".json":
        return path.read_bytes()
    certificate = json.loads(path.read_text())
    for section in UNSTABLE:
        certificate.pop(section)
    (certificate["connectivity"]["optimality"] or {}).pop("seconds", None)
    request = certificate.pop("request")  # holds paths of this run's folder
    request.pop("image")
    return json.dumps([certificate, request], sort_keys=True).encode()


def _plate(seed: int) -> list[str]:
    draw = random.Random(seed)
    text = "".join(
        draw.choices(draw.choice((string.digits, string.ascii_letters, "äöü語ключ€ ")), k=draw.randint(3, 40))
    )
    options: dict[str, Any] = {
        "--level": draw.choice("LMQH"),
        "--size": draw.choice((65, 80, 110)),
        "--thickness": draw.choice((0.8, 1.6, 2.4)),
        "--nozzle": draw.choice((0.25, 0.4)),
        "--style": draw.choice(("square", "square", "rounded", "dots", "bars")),
        "--finder": draw.choice(("panel", "recessed", "recessed", "diagonal")),
        "--draft": draw.choice((0, 0, 8)),
        "--support": draw.choice(("clamped", "simple", "corners")),
        "--pressure": draw.choice((5e-6, 1e-3)),
        "--seed": seed,
    }
    return [text, *(str(word) for option in options.items() for word in option)]


def _picture(folder: Path) -> Path:
    import runpy

    path = folder / "picture.png"
    argv, sys.argv = sys.argv, ["picture_code.py", str(path)]
    runpy.run_path(str(Path(__file__).parents[2] / "examples" / "picture_code.py"), run_name="__main__")
    sys.argv = argv
    return path


def _tray(folder: Path) -> Path:
    from build123d import Box, export_step

    path = folder / "tray.step"
    export_step(Box(34, 2, 34), str(path))
    return path


def _mesh(folder: Path) -> Path:
    import trimesh

    path = folder / "tray.stl"
    trimesh.creation.box((34, 2, 34)).export(path)
    return path


def run(verb: str, numbers: list[int]) -> int:
    """Record the hashes, or print what differs from those recorded; the number of differences."""
    known = json.loads(RECORD.read_text()) if RECORD.exists() else {}
    differences = 0
    with tempfile.TemporaryDirectory() as scratch:
        asked = requests(Path(scratch))
        for number in numbers or range(len(asked)):
            found = written(asked[number], Path(scratch) / f"{number}")
            before = known.get(str(number), {})
            changed = sorted(name for name in {*found, *before} if found.get(name) != before.get(name))
            differences += len(changed)
            print(number, "same" if not changed else f"differs: {', '.join(changed)}", flush=True)
            known[str(number)] = found
    if verb == "record":
        RECORD.write_text(json.dumps(known, indent=1) + "\n")
    return differences


if __name__ == "__main__":
    difference = run(sys.argv[1], [int(number) for number in sys.argv[2:]])
    sys.exit(1 if sys.argv[1] == "check" and difference else 0)
