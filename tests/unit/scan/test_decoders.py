"""The panel: right payloads only, noise reads nothing, crashes and hangs are misses."""

import signal
from pathlib import Path

import numpy as np
import pytest
import segno

from perfqr_cad.errors import AnalysisError
from perfqr_cad.isolated import Limits
from perfqr_cad.scan.decoding import decoders, node
from perfqr_cad.scan.decoding.panel import Losses, Panel

TEXT = "https://example.com/p/1234567"


def picture(text: str | bytes, version: int = 5) -> np.ndarray:
    rows = np.array([list(row) for row in segno.make(text, version=version, error="m").matrix], bool)
    modules = np.pad(rows, 4)
    return np.where(np.kron(modules, np.ones((8, 8), bool)), 20, 230).astype(np.uint8)


@pytest.fixture(scope="module")
def panel():
    with Panel(workers=1) as panel:
        yield panel


def test_every_present_decoder_reads_a_plain_code(panel):
    assert {"zxing-cpp", "zbar", "wechat", "opencv"} <= set(panel.names)
    reading = panel.read(picture(TEXT))
    assert reading == dict.fromkeys(panel.names, (TEXT.encode(),))


def test_noise_reads_nothing(panel):
    noise = np.random.default_rng(1).integers(0, 256, (300, 300), np.uint8)
    assert panel.read(noise) == dict.fromkeys(panel.names, ())


def test_names_choose_who_sees_which_picture(panel):
    code = picture(TEXT)
    readings = panel.read_all([code, code], names=[["zbar"], ["opencv", "zxing-cpp"]])
    assert [set(reading) for reading in readings] == [{"zbar"}, {"opencv", "zxing-cpp"}]


def test_bytes_that_are_no_utf8_come_back_exactly(panel):
    payload = b"caf\xe9 \xff\x00\x01"
    read = [name for name, found in panel.read(picture(payload)).items()
            if decoders.accepted(payload).intersection(found)]  # fmt: skip
    assert "zxing-cpp" in read


def test_accepted_knows_raw_bytes_and_text():
    assert decoders.accepted("abc") == {b"abc"}
    assert decoders.accepted("é") == {"é".encode(), b"\xe9"}
    assert decoders.accepted(b"\xe9") == {"é".encode(), b"\xe9"}
    assert b"abd" not in decoders.accepted("abc")


def test_unknown_decoder_is_refused():
    with pytest.raises(AnalysisError, match="choose from zxing-cpp"):
        Panel(["no-such-decoder"])


def test_colour_pictures_are_refused(panel):
    with pytest.raises(ValueError, match="gray uint8"):
        panel.read(np.zeros((9, 9, 3), np.uint8))


SICK = """
import os, signal, time
from perfqr_cad.isolated import Message

def reader(*names):
    def answer(request):
        {symptom}
    answer.report = {{}}
    return answer
"""


def sick(folder: Path, symptom: str) -> str:
    """A job whose every reading ends with a symptom."""
    path = folder / "sick.py"
    path.write_text(SICK.format(symptom=symptom))
    return f"{path}:reader"


@pytest.mark.parametrize(
    ("symptom", "kind"),
    [
        ("os.kill(os.getpid(), signal.SIGSEGV)", "crashes"),
        ("raise KeyError(1)", "crashes"),
        ("while True: pass", "timeouts"),
    ],
)
def test_crash_and_hang_are_misses_and_counted(tmp_path, symptom, kind):
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # as the solid modeller leaves it
    with Panel(["zbar"], workers=1, job=sick(tmp_path, symptom), limits=Limits(cpu_s=0.2)) as panel:
        code = picture(TEXT)
        # A new process takes over, with the same illness.
        assert panel.read_all([code, code]) == [{"zbar": ()}, {"zbar": ()}]
        assert getattr(panel.losses, kind) == {"zbar": 2}
        assert f"zbar {'crashed' if kind == 'crashes' else 'met its limit'}" in panel.losses.sentences()[0]
        assert panel.losses.since(panel.losses) == Losses()


def test_a_decoder_process_that_dies_at_its_start_is_told_at_once_with_its_reason(tmp_path):
    (tmp_path / "dead.py").write_text("raise ImportError('libnowhere.so.0: cannot open')")
    with (
        Panel(["zbar"], job=f"{tmp_path / 'dead.py'}:reader") as panel,
        pytest.raises(AnalysisError, match=r"does not start .*ImportError: libnowhere\.so\.0: cannot open"),
    ):
        panel.read(picture(TEXT))


def test_an_engine_without_its_library_is_left_out_and_named(tmp_path):
    # pyzbar finds its library by ctypes.util; a folder of modules of our own comes before it.
    (tmp_path / "job.py").write_text(
        "import ctypes.util\n"
        "ctypes.util.find_library = lambda name: None\n"
        "from perfqr_cad.scan.decoding.worker import Readers\n"
    )
    with Panel(["zbar", "opencv"], workers=1, job=f"{tmp_path / 'job.py'}:Readers") as panel:
        assert panel.names == ("opencv",)
        assert panel.left_out == {"zbar": "Unable to find zbar shared library"}
        assert panel.read(picture(TEXT)) == {"opencv": (TEXT.encode(),)}
    with (
        Panel(["zbar"], workers=1, job=f"{tmp_path / 'job.py'}:Readers") as panel,
        pytest.raises(AnalysisError, match="none of 1 decoders can be loaded"),
    ):
        panel.read(picture(TEXT))


def test_an_interrupt_ends_the_panel_at_once(panel):
    def interrupted(done: int) -> None:
        signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        panel.read_all([picture(TEXT)] * 50, progress=interrupted)
    assert panel.read(picture(TEXT))["zbar"] == (TEXT.encode(),)


def test_node_modules_come_from_a_full_path_alone(monkeypatch, tmp_path):
    package = tmp_path / "node_modules" / "jsqr"
    package.mkdir(parents=True)
    (package / "package.json").write_text('{"main": "index.js"}')
    (package / "index.js").write_text(f"require('fs').writeFileSync({str(tmp_path / 'RUN')!r}, '')")
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("PERFQR_NODE_MODULES", raising=False)
    monkeypatch.setattr(node, "HOME", tmp_path / "elsewhere")
    assert "jsqr" not in decoders.available()
    monkeypatch.setenv("PERFQR_NODE_MODULES", "node_modules")
    with pytest.raises(AnalysisError, match=f"give the full path, {tmp_path}"):
        decoders.available()
    assert not (tmp_path / "RUN").exists()
