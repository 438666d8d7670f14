# make demo   the main job, from nothing: a text and a picture become parts in out/
# make test   all checks and tests
# Both do their own set-up: virtual environment, Python packages, system libraries.

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin

# Shared libraries: libgl1 for the solid modeller and VTK; the X and GLU ones for gmsh; zbar for pyzbar.
SYSTEM_PACKAGES := libgl1 libegl1 libglu1-mesa libxcursor1 libxft2 libxinerama1 libxrender1 libgomp1 libzbar0

# Programs that judge from outside; tests that need one are skipped by name where it is missing.
WITNESSES := calculix-ccx freecad-python3 prusa-slicer openscad chromium

.PHONY: demo test test-all setup system lint types layers unit bench clean

demo: setup
	$(BIN)/perfqr make "https://example.com/p/1234567" --size 60 -o out/text/
	$(BIN)/python examples/picture_code.py out/picture.png
	$(BIN)/perfqr make --image out/picture.png -o out/picture/

test: setup-test lint types layers unit

setup: $(VENV)/.runtime

setup-test: $(VENV)/.test

$(VENV)/.runtime: pyproject.toml
	@$(MAKE) --no-print-directory system
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e .
	@touch $@

$(VENV)/.test: pyproject.toml
	@$(MAKE) --no-print-directory system
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[test]'
	@touch $@ $(VENV)/.runtime

system:
	@sh .ci/system-packages $(SYSTEM_PACKAGES)

lint:
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types:
	$(BIN)/pyright

layers:
	$(BIN)/lint-imports

unit:
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --dist loadfile --max-worker-restart=0

# Every witness installed, new random examples, no test skipped: before a release.
test-all: setup-test
	@sh .ci/system-packages $(SYSTEM_PACKAGES) $(WITNESSES)
	HYPOTHESIS_PROFILE=new OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --dist loadfile --no-skips

bench: setup-test
	$(BIN)/perfqr bench

clean:
	rm -rf $(VENV) out build *.egg-info
