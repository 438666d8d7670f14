"""Readers that run under Node.js, where it is present: jsQR and the WebAssembly build of ZBar.

They are found where this program's user put them, never in the current folder: in the folder that the
environment variable PERFQR_NODE_MODULES names by its full path, else in `HOME`, where
`npm install --prefix HOME jsqr @undecaf/zbar-wasm` puts them.
"""

from __future__ import annotations

import ctypes
import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.errors import AnalysisError

HOME = Path(sys.prefix) / "share" / "perfqr-cad" / "node"  # beside the installation
PR_SET_PDEATHSIG = 1  # prctl(2)

_LOOP = """
import { createRequire } from 'node:module'
const [folder, name] = process.argv.slice(1)
const require = createRequire(folder + '/')
const library = require(name)
const decode = name === 'jsqr' ? jsqr : zbar
function jsqr(gray, width, height) {
  const rgba = new Uint8ClampedArray(4 * width * height).fill(255)
  for (let i = 0; i < gray.length; i++) rgba[4 * i] = rgba[4 * i + 1] = rgba[4 * i + 2] = gray[i]
  const found = (library.default ?? library)(rgba, width, height)
  return found ? [Buffer.from(found.data, 'utf8').toString('hex')] : []
}
async function zbar(gray, width, height) {
  const buffer = gray.buffer.slice(gray.byteOffset, gray.byteOffset + gray.length)
  const found = await library.scanGrayBuffer(buffer, width, height)
  return found.filter(s => s.typeName === 'ZBAR_QRCODE').map(s => Buffer.from(s.data).toString('hex'))
}
let pending = Buffer.alloc(0), need = null
process.stdin.on('end', () => process.exit())
process.stdin.on('data', async chunk => {
  pending = Buffer.concat([pending, chunk])
  if (need === null) {
    const end = pending.indexOf(10)
    if (end < 0) return
    need = JSON.parse(pending.subarray(0, end))
    pending = pending.subarray(end + 1)
  }
  if (pending.length < need.width * need.height) return
  const { width, height } = need, image = pending
  pending = Buffer.alloc(0); need = null
  let answer = []
  try { answer = await decode(image, width, height) } catch { answer = [] }
  process.stdout.write(JSON.stringify(answer) + '\\n')
})
"""


def modules_folder() -> Path:
    """Where the packages are looked for. AnalysisError if the environment names it by a relative path."""
    folder = Path(os.environ.get("PERFQR_NODE_MODULES") or HOME / "node_modules")
    if not folder.is_absolute():
        raise AnalysisError(
            f"PERFQR_NODE_MODULES={folder} depends on the current folder: give the full path, "
            f"{folder.resolve()}"
        )
    return folder


def present(package: str) -> bool:
    """True if Node.js and the package can be run here."""
    return shutil.which("node") is not None and (modules_folder() / package / "package.json").is_file()


def reader(package: str) -> Callable[[NDArray[np.uint8]], tuple[bytes, ...]]:
    """A reading function backed by a persistent Node.js process, which ends with ours."""
    process = subprocess.Popen(
        ["node", "--input-type=module", "-e", _LOOP, str(modules_folder()), package],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={name: value for name, value in os.environ.items() if not name.startswith("NODE_")},
        preexec_fn=_die_with_parent,
    )
    requests, answers = process.stdin, process.stdout
    assert requests is not None
    assert answers is not None

    def read(image: NDArray[np.uint8]) -> tuple[bytes, ...]:
        height, width = image.shape
        header = json.dumps({"height": height, "width": width}).encode() + b"\n"
        requests.write(header + np.ascontiguousarray(image).tobytes())
        requests.flush()
        answer = answers.readline()
        if not answer:
            raise EOFError(f"Node.js ended at {package}")
        return tuple(bytes.fromhex(payload) for payload in json.loads(answer))

    return read


def _die_with_parent() -> None:
    """Have the kernel end the process that is being started when ours ends; Linux only."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
