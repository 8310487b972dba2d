# `make demo` and `make test` need nothing but Python 3.11+ and make: each sets itself up.
# With LOCKED=1 exactly the versions of constraints.txt are installed, by their hashes.
PYTHON ?= python3
VENV ?= .venv
BIN = $(VENV)/$(if $(filter Windows_NT,$(OS)),Scripts,bin)
LOCKED ?=
PIP = $(BIN)/python -m pip --quiet --disable-pip-version-check

.PHONY: demo test lint types docs dist extras fuzz mutants check web clean

demo: $(VENV)/.installed  ## Segment the built-in motorcycle scene, as by default and as the paper
	$(BIN)/geohue segment --sample motorcycle -o out/motorcycle/best
	$(BIN)/geohue segment --sample motorcycle --preset paper -o out/motorcycle/paper
	@echo "The segments:        out/motorcycle/best/overlay.png beside out/motorcycle/paper/overlay.png"
	@echo "How sure a border is: out/motorcycle/best/borders.png"
	@echo "Q over the weight:    out/motorcycle/paper/weight_curve.png"

test: $(VENV)/.installed-dev  ## Run all tests
	$(BIN)/python -m pytest

lint: $(VENV)/.installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports

types: $(VENV)/.installed-dev
	$(BIN)/mypy

docs: $(VENV)/.installed-dev  ## Build the pages into docs/_build; a warning is an error
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs docs/_build

dist: $(VENV)/.installed-dev  ## Build wheel and sdist, check them, and try the wheel as a user would
	PYTHON="$(abspath $(BIN))/python" .ci/dist

extras: $(VENV)/.installed-dev  ## Each extra alone, all together, oldest and newest versions
	$(BIN)/python -m nox --non-interactive

CASES ?= 4000
fuzz: $(VENV)/.installed-dev  ## Damaged files, strange scenes and odd arguments, CASES of each kind
	GEOHUE_FUZZ_CASES=$(CASES) $(BIN)/python -m pytest -q $(wildcard tests/*/test_fuzz_*.py)

mutants: $(VENV)/.installed-dev  ## Small faults put into the core: how many do the tests notice?
	$(BIN)/python -m benchmarks.mutants

check: lint types test

web: web/node_modules/.package-lock.json  ## Build the page of `geohue serve` from web/
	npm --prefix web run --silent build

web/node_modules/.package-lock.json: web/package.json web/package-lock.json
	npm --prefix web ci --silent

clean:
	rm -rf $(VENV) out build dist docs/_build docs/examples docs/generated .mypy_cache .ruff_cache .pytest_cache .hypothesis

$(VENV)/.made:
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "geohue needs Python 3.11 or newer")'
	$(PYTHON) -m venv $(VENV)
	@touch $@

$(VENV)/.installed: pyproject.toml | $(VENV)/.made
	$(PIP) install -e .
	@touch $@

$(VENV)/.installed-dev: pyproject.toml constraints.txt | $(VENV)/.made
	$(if $(LOCKED),$(PIP) install --require-hashes -r constraints.txt)
	$(PIP) install $(if $(LOCKED),--no-deps) -e '.[dev,docs,clouds,datasets,ros,web]'
	@touch $@ $(VENV)/.installed

constraints.txt:  # make -B constraints.txt: the newest versions that pass together
	$(PYTHON) -m venv $(VENV)-lock
	$(VENV)-lock/bin/python -m pip --quiet install pip-tools
	$(VENV)-lock/bin/pip-compile --quiet --upgrade --generate-hashes --all-extras --strip-extras \
	  --allow-unsafe --no-header --no-annotate --no-emit-index-url --no-emit-find-links \
	  --no-emit-trusted-host --no-emit-options -o $@ pyproject.toml
	rm -rf $(VENV)-lock
