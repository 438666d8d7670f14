"""The panel: right payloads only, noise reads nothing, crashes and hangs are misses."""

import signal
import sys

import numpy as np
import pytest
import segno

from perfqr_cad.errors import AnalysisError
from perfqr_cad.scan.decoding import decoders
from perfqr_cad.scan.decoding.panel import Panel, Worker

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
import sys
sys.stdout.write('ready\\n'); sys.stdout.flush()
sys.stdin.buffer.readline()
{symptom}
"""


@pytest.mark.parametrize("symptom", ["import os; os.abort()", "import time; time.sleep(60)"])
def test_crash_and_hang_are_misses(symptom):
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # as the solid modeller leaves it
    worker = Worker([], 0.5, [sys.executable, "-c", SICK.format(symptom=symptom)])
    code = picture(TEXT)
    assert worker.ask("any", code) == ()
    assert worker.ask("any", code) == ()  # a new process takes over, with the same illness
    worker.stop()


def test_worker_that_never_starts_is_an_error():
    worker = Worker([], 0.5, [sys.executable, "-c", "pass"])
    with pytest.raises(AnalysisError, match="did not start"):
        worker.ask("any", picture(TEXT))
