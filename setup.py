"""Packages of the wheel: `templates/` lies beside the package in a checkout and inside it once installed.

All else is declared in pyproject.toml, which can list packages or find them, but not both.
"""

from setuptools import find_packages, setup

TEMPLATES = "perfqr_cad.templates"

setup(
    packages=[*find_packages(include=["perfqr_cad", "perfqr_cad.*"]), TEMPLATES],
    package_dir={TEMPLATES: "templates"},
)
