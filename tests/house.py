"""The size and shape of the package: `python tests/house.py`.

Prints folders by files and lines, long functions and modules, functions of many arguments, and names that
stand for two things. What is out of the ordinary has its reason in `REASONS`; `tests/unit/test_house.py`
holds both.
"""

from __future__ import annotations

import ast
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

PACKAGE = Path(__file__).parents[1] / "perfqr_cad"
MOST_FILES, MOST_LINES, MOST_FUNCTION_LINES, MOST_ARGUMENTS = 16, 330, 60, 8

# Place -> why it may be larger than the rest, or why two things share a name.
MIRROR = "benchmarks and experiments carry the name of what they measure"
REASONS: dict[str, str] = {
    "cli.py:batch": "the options of the shell; settings of the parts come from their declarations",
    "cli.py:make": "the options of the shell; settings of the part come from their declarations",
    "pipeline/request.py": "one declaration for every setting",
    "symbol/encoding.py:encode": "a public entry, all arguments but the text by keyword with a default",
    "scan/proof.py:certify": "a public entry, five of its arguments by keyword with a default",
    "capture.py": MIRROR,
    "certificate.py": "the pipeline makes it, export writes it as JSON",
    "colours.py": MIRROR,
    "finder.py": MIRROR,
    "freedom.py": MIRROR,
    "pattern.py": MIRROR,
    "reader.py": "one for each kind of input, in its folder",
    "svg.py": "capture reads drawings, export writes them",
    "worker.py": "the process that runs foreign code, and the decoders that run in it",
}


@dataclass(frozen=True)
class Oddity:
    """Something a reader would stumble over: where it is, and what it is."""

    place: str
    what: str

    @property
    def reason(self) -> str | None:
        """Why it may stay."""
        return REASONS.get(self.place)


def modules() -> list[Path]:
    """Every module of the package."""
    return sorted(PACKAGE.rglob("*.py"))


def name_of(path: Path) -> str:
    """A module's path inside the package."""
    return path.relative_to(PACKAGE).as_posix()


def functions(path: Path) -> Iterator[tuple[str, ast.FunctionDef | ast.AsyncFunctionDef]]:
    """Every function of a module, methods as Class.name."""
    for node in ast.walk(ast.parse(path.read_text())):
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
                owner = f"{node.name}." if isinstance(node, ast.ClassDef) else ""
                yield owner + child.name, child


def folders() -> list[tuple[str, int, int]]:
    """Folders by files and lines of their own."""
    found: dict[str, list[int]] = defaultdict(list)
    for path in modules():
        found[name_of(path.parent)].append(len(path.read_text().splitlines()))
    return [(folder, len(lines), sum(lines)) for folder, lines in sorted(found.items())]


def oddities() -> list[Oddity]:
    """All that is out of the ordinary."""
    found = [Oddity(folder, f"{count} files") for folder, count, _ in folders() if count > MOST_FILES]
    classes: dict[str, list[str]] = defaultdict(list)
    stems: Counter[str] = Counter()
    for path in modules():
        place, source = name_of(path), path.read_text()
        lines = len(source.splitlines())
        if lines > MOST_LINES:
            found.append(Oddity(place, f"{lines} lines"))
        for name, node in functions(path):
            found += _of_function(f"{place}:{name}", node)
        for node in ast.parse(source).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                classes[node.name].append(place)
        stems[path.stem] += not path.stem.startswith("__")
    found += [
        Oddity(name, f"class in {', '.join(at)}") for name, at in sorted(classes.items()) if len(at) > 1
    ]
    found += [Oddity(f"{stem}.py", f"{n} modules") for stem, n in sorted(stems.items()) if n > 1]
    return found


def _of_function(place: str, node: ast.FunctionDef | ast.AsyncFunctionDef) -> Iterator[Oddity]:
    lines = (node.end_lineno or node.lineno) - node.lineno + 1
    given = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
    arguments = len([a for a in given if a.arg not in ("self", "cls")])
    if lines > MOST_FUNCTION_LINES:
        yield Oddity(place, f"{lines} lines")
    if arguments > MOST_ARGUMENTS:
        yield Oddity(place, f"{arguments} arguments")


def main() -> None:
    """Print it."""
    rows = folders()
    print(f"{sum(count for _, count, _ in rows)} modules, {sum(lines for *_, lines in rows)} lines")
    for folder, count, lines in rows:
        print(f"{folder:24} {count:3} files {lines:6} lines")
    for oddity in oddities():
        print(f"{oddity.place}: {oddity.what}: {oddity.reason or 'NO REASON'}")


if __name__ == "__main__":
    main()
