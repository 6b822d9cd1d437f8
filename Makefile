# `make run` plans the calibration of the example hexapod; `make test` checks everything,
# `make studies` makes the thesis' studies again, `make release` builds the distribution.
PYTHON ?= $(or $(shell command -v python3.11 2>/dev/null),python3)
VENV := .venv
BIN := $(VENV)/bin
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt
CONFIG ?= configs/hexapod-h1.yaml
CODE := src tests docs research conftest.py

.PHONY: run test lint proof studies results release docs clean

# What is installed, by a file in the environment for each: running needs the package alone, tests its extras as well.
$(VENV)/running: pyproject.toml constraints.txt
	@command -v $(PYTHON) >/dev/null || { echo "there is no $(PYTHON) here; name another: make PYTHON=python3"; exit 2; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
		echo "$(PYTHON) is older than 3.11; name another: make PYTHON=python3.12"; exit 2; }
	$(PYTHON) -m venv $(VENV)
	@echo "installing what running needs into $(VENV) (0.85 GB)"
	@$(INSTALL) -e .
	@touch $@

$(VENV)/testing: $(VENV)/running
	@echo "installing the tools of development into $(VENV) (1.2 GB more)"
	@$(INSTALL) -e '.[cluster,dev,laboratory,studies]'
	@touch $@

run: $(VENV)/running
	$(BIN)/expdesign run $(CONFIG)

lint: $(VENV)/testing
	$(BIN)/ruff format --check $(CODE)
	$(BIN)/ruff check $(CODE)
	$(BIN)/mypy

test: lint
	$(BIN)/pytest -n 2 --dist worksteal -m "not slow" tests

proof: $(VENV)/testing
	$(BIN)/pytest -m slow

studies: $(VENV)/testing
	$(BIN)/python -m research.studies --force

# A page of results/ by the commands that stand on it: make results NAME=false-alarms
results: $(VENV)/testing
	$(BIN)/python -m research.benchmarks.page $(NAME)

# The wheel and the source archive, into dist/.
release: $(VENV)/testing
	rm -rf build dist
	$(BIN)/python -m build

$(VENV)/docs: $(VENV)/testing
	$(INSTALL) -e '.[docs]'
	@touch $@

# The documentation as pages that open from their files: site/index.html. Broken links are errors.
docs: $(VENV)/docs
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet
	@echo "site/index.html"

clean:
	rm -rf $(VENV) site build dist
