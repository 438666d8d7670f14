"""The certificate as JSON: what was measured, and the files it was measured on."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from perfqr_cad.export.design_view import DesignView


def write(design: DesignView, path: Path, *, files: Sequence[Mapping[str, Any]] | None = None) -> None:
    """Write `design.certificate()`; `files`, where given, replaces its list of files."""
    certificate = design.certificate()
    if files is not None:
        certificate = certificate | {"files": list(files)}
    text = json.dumps(json_ready(certificate), indent=2, ensure_ascii=False, allow_nan=False)
    path.write_text(text + "\n", "utf-8")


def json_ready(value: Any) -> Any:
    """The value in JSON's own types: arrays as lists, and null for what has no finite value."""
    if isinstance(value, Mapping):
        return {str(key): json_ready(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return json_ready(value.tolist())
    if isinstance(value, list | tuple):
        return [json_ready(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
