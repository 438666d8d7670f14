"""A template is somebody's code: whatever it does ends in a design or in one line."""

import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from perfqr_cad import catalog
from perfqr_cad.errors import DesignError, PerfQRError, TemplateError
from perfqr_cad.pipeline import chain
from perfqr_cad.pipeline.design import Design


def template(folder: Path, source: str) -> catalog.Template:
    path = folder / "tag.py"
    path.write_text(source)
    return catalog.find(str(path))


def built(folder: Path, body: str, timeout_s: float = 60.0) -> Design:
    head = "import sys\nfrom perfqr_cad import Design, DesignError, make\n\nsize = 0\n"
    return template(folder, f"{head}def build(p):\n    {body}\n").build(timeout_s=timeout_s)


def test_a_design_comes_back(tmp_path: Path) -> None:
    assert isinstance(built(tmp_path, "return Design.__new__(Design)"), Design)


@pytest.mark.parametrize(
    ("body", "says"),
    [
        ("return 1 / p.size", "tag.py line 6: ZeroDivisionError"),
        ("pass", "build(p) of tag.py returns nothing"),
        ("return 3", "returns 3, which is no Design"),
        ("return [[[]]] * 9", "which is no Design"),
        ("return p.wide", "tag.py line 6: AttributeError"),
        ("import numpy; return numpy.linalg.inv(numpy.zeros((2, 2)))", "tag.py line 6: LinAlgError"),
        ("import numpy; return numpy.zeros(3)[7]", "tag.py line 6: IndexError"),
        ("return make(text=3)", "text=3 is no text"),
        ("return make(text='A', size=3)", "no setting 'size'"),
        ("return make('A', 'B')", "tag.py line 6: TypeError"),
        ("sys.exit(0)", "tag.py line 6 ends the program"),
        ("sys.exit(5)", "tag.py line 6 ends the program"),
        ("sys.exit('x')", "tag.py line 6 ends the program"),
        ("return build(p)", "RecursionError"),
        ("raise MemoryError", "MemoryError"),
    ],
)
def test_what_a_template_gets_wrong_is_told(tmp_path: Path, body: str, says: str) -> None:
    with pytest.raises(PerfQRError) as told:
        built(tmp_path, body)
    assert says in str(told.value)


def test_its_own_refusals_stay_as_they_are(tmp_path: Path) -> None:
    with pytest.raises(DesignError, match=r"^too small$"):
        built(tmp_path, "raise DesignError('too small')")


@pytest.mark.parametrize(
    ("source", "says"),
    [
        ("def build(p): return 1\ndel build\n", "takes its build"),
        ("def build(): return 1\n", "takes no values"),
        ("build = 3\n", "defines no build"),
        ("import nothing_of_this_name\ndef build(p): return 1\n", "line 1: ModuleNotFoundError"),
        ("raise SystemExit\ndef build(p): return 1\n", "line 1 ends the program"),
        ("def build(p:\n", "line 1"),
        (f"x = {'[' * 2000}{']' * 2000}\ndef build(p): return 1\n", "tag.py"),
        (f"x = {'-' * 5000}1\ndef build(p): return 1\n", "tag.py"),
        (f"x = {'9' * 5000}\ndef build(p): return 1\n", "tag.py"),
        ("x = '\0'\ndef build(p): return 1\n", "tag.py"),
        ("size = 3  # [Shared\n# [Shared: Nothing]\ndef build(p): return 1\n", "no shared group"),
        ("# [Shared: Code]\nsize = 99999\ndef build(p): return 1\n", "outside 1 to 10000 mm"),
    ],
)
def test_a_source_that_is_no_template(tmp_path: Path, source: str, says: str) -> None:
    with pytest.raises(TemplateError) as told:
        template(tmp_path, source).build()
    assert says in str(told.value)


def test_literals_that_are_no_values_are_the_templates_own(tmp_path: Path) -> None:
    source = (
        "a = {[]: 1}\nb = {'k': 1}\nc = [[1]]\nd = b'x'\ne = 1j\nf = ['x']\ng = 2\ndef build(p): return 1\n"
    )
    assert [p.name for p in template(tmp_path, source).parameters] == ["g"]


@pytest.mark.parametrize(
    "loop",
    [
        "while True: pass",
        "while True:\n        try: p.x\n        except Exception: pass",
        "[0 for _ in iter(int, 1)]",
        "import time; time.sleep(60)",
        "import threading; threading.Event().wait()",
        "import subprocess; subprocess.run(['sleep', '60'])",
        "import select; select.select([], [], [])",
    ],
)
def test_a_loop_without_an_end_is_ended(tmp_path: Path, loop: str) -> None:
    with pytest.raises(TemplateError, match=r"waits for 0.5 s without an end: .*--template-timeout"):
        built(tmp_path, loop, timeout_s=0.5)


def test_a_wait_between_work_is_none(tmp_path: Path) -> None:
    body = "import time\n    for _ in range(4): time.sleep(0.3); sum(range(3_000_000))\n    return 3"
    with pytest.raises(TemplateError, match="returns 3"):
        built(tmp_path, body, timeout_s=0.9)


SWALLOWING = [
    "while True:\n        try: p.size\n        except: pass",
    "import contextlib\n    while True:\n        with contextlib.suppress(BaseException): p.size",
    "while True:\n        try:\n            while True: pass\n        finally: continue",
]


@pytest.mark.parametrize("loop", SWALLOWING)
def test_an_end_that_is_swallowed_ends_the_command(tmp_path: Path, loop: str) -> None:
    (tmp_path / "tag.py").write_text(f"size = 0\ndef build(p):\n    {loop}\n")
    make = [
        sys.executable,
        "-m",
        "perfqr_cad",
        "make",
        "-t",
        "tag.py",
        "-o",
        "part/",
        "--template-timeout",
        "0.5",
    ]
    done = subprocess.run(make, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.splitlines() == [
        "error: tag.py computes or waits for 0.5 s without an end: simplify it, or raise --template-timeout"
    ]
    assert [path.name for path in tmp_path.iterdir()] == ["tag.py"]


def test_what_make_takes_is_not_the_templates_own_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A part may take minutes: CPU seconds below `make` do not count."""

    def spin(*_: object) -> None:
        end_s = time.process_time() + 1.5
        while time.process_time() < end_s:
            pass

    monkeypatch.setattr(chain, "run", spin)
    with pytest.raises(TemplateError, match="returns nothing"):
        built(tmp_path, "return make('A')", timeout_s=0.5)


def test_beside_the_main_thread_nothing_is_limited(tmp_path: Path) -> None:
    found: list[Design] = []
    worker = threading.Thread(
        target=lambda: found.append(built(tmp_path, "return Design.__new__(Design)", timeout_s=0.5))
    )
    worker.start()
    worker.join()
    assert len(found) == 1


def test_a_limit_that_is_none(tmp_path: Path) -> None:
    for limit_s in (0.0, -1.0, float("nan")):
        with pytest.raises(TemplateError, match="above 0"):
            built(tmp_path, "pass", timeout_s=limit_s)
