"""The fuzz targets run where atheris is installed: `pip install -e '.[fuzz]'`."""

import importlib.util

collect_ignore = [] if importlib.util.find_spec("atheris") else ["test_doors.py"]
