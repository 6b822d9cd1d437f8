# `make run` plans the calibration of the example hexapod; `make test` checks everything,
# `make studies` makes the thesis' studies again.
PYTHON ?= python3.11
VENV := .venv
BIN := $(VENV)/bin
CONFIG ?= configs/hexapod-h1.yaml

.PHONY: run test lint proof studies docs clean

$(VENV)/installed: pyproject.toml constraints.txt
	@command -v $(PYTHON) >/dev/null || { echo "$(PYTHON) is needed (or: make PYTHON=python3)"; exit 2; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[cluster,dev,laboratory,studies]'
	touch $@

run: $(VENV)/installed
	$(BIN)/expdesign run $(CONFIG)

lint: $(VENV)/installed
	$(BIN)/ruff format --check src tests benchmarks docs
	$(BIN)/ruff check src tests benchmarks docs
	$(BIN)/mypy

test: lint
	$(BIN)/pytest -n 2 -m "not slow"

proof: $(VENV)/installed
	$(BIN)/pytest -m slow

studies: $(VENV)/installed
	$(BIN)/expdesign study all

$(VENV)/docs: $(VENV)/installed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[docs]'
	touch $@

# The documentation as pages that open from their files: site/index.html. Broken links are errors.
docs: $(VENV)/docs
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet
	@echo "site/index.html"

clean:
	rm -rf $(VENV) site
