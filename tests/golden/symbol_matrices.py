"""Writes symbol_matrices.json: digests of the 40 × 4 × 8 matrices on which segno and qrcodegen agree.

    python tests/golden/symbol_matrices.py

Both encoders draw the same digits, half of what the symbol holds, and must agree before a digest is kept.
The number of digits avoids segno 1.6.6's wrong pad codeword after data that ends on a codeword boundary
(its issues 123 and 148). Takes some minutes: both encoders are written in plain Python.
"""

import hashlib
import json
from pathlib import Path

import numpy as np
import qrcodegen
import segno

GOLDEN = Path(__file__).with_name("symbol_matrices.json")
ECC = {
    "L": qrcodegen.QrCode.Ecc.LOW,
    "M": qrcodegen.QrCode.Ecc.MEDIUM,
    "Q": qrcodegen.QrCode.Ecc.QUARTILE,
    "H": qrcodegen.QrCode.Ecc.HIGH,
}


def numeric_bits(digits: int, version: int) -> int:
    """Mode, count, digits and terminator (ISO/IEC 18004 §7.4.3)."""
    count = 10 if version <= 9 else 12 if version <= 26 else 14
    return 4 + count + 10 * (digits // 3) + (0, 4, 7)[digits % 3] + 4


def digits_for(version: int, level: str) -> str:
    """Digits that fill half of the symbol and do not end on a codeword boundary."""
    data_bits = 8 * qrcodegen.QrCode._get_num_data_codewords(version, ECC[level])
    count = data_bits // 2 * 3 // 10
    while numeric_bits(count, version) % 8 == 0:
        count -= 1
    return "".join(str((7 * k * k + 3 * k + version) % 11 % 10) for k in range(count))


def digest(dark: np.ndarray) -> str:
    return hashlib.sha256(np.packbits(dark).tobytes()).hexdigest()[:16]


def by_qrcodegen(text: str, version: int, level: str, mask: int) -> np.ndarray:
    segments = [qrcodegen.QrSegment.make_numeric(text)]
    code = qrcodegen.QrCode.encode_segments(segments, ECC[level], version, version, mask, False)
    side = range(code.get_size())
    return np.array([[code.get_module(x, y) for x in side] for y in side])


def by_segno(text: str, version: int, level: str, mask: int) -> np.ndarray:
    code = segno.make(text, version=version, error=level, mask=mask, boost_error=False, micro=False)
    return np.array([list(row) for row in code.matrix]) == 1


def main() -> None:
    digests: dict[str, list[str]] = {}
    for version in range(1, 41):
        for level in ECC:
            text = digits_for(version, level)
            row = digests.setdefault(f"{version}-{level}", [])
            for mask in range(8):
                dark = by_qrcodegen(text, version, level, mask)
                if not np.array_equal(dark, by_segno(text, version, level, mask)):
                    raise SystemExit(f"segno and qrcodegen disagree on {version}-{level}, mask {mask}")
                row.append(digest(dark))
    lines = [f"{json.dumps(name)}: {json.dumps(row)}" for name, row in digests.items()]
    GOLDEN.write_text("{\n" + ",\n".join(lines) + "\n}\n")


if __name__ == "__main__":
    main()
