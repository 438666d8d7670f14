"""The fuzz targets run where atheris is installed: `pip install -e '.[fuzz]'`."""

import importlib.util

collect_ignore = ["doors.py"]  # a program, and no examples in it
if importlib.util.find_spec("atheris") is None:
    collect_ignore.append("test_doors.py")
