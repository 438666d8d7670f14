"""Write docs/settings.md from the declarations of the settings: `python docs/settings.py`."""

from pathlib import Path

from perfqr_cad.catalog.reference import page

Path(__file__).with_suffix(".md").write_text(page(), encoding="utf-8")
