# `make demo` and `make test` need nothing but Python 3.11+ and make: each sets itself up.
# With LOCKED=1 exactly the versions of constraints.txt are installed, by their hashes.
PYTHON ?= python3
VENV ?= .venv
LOCKED ?=
PIP = $(VENV)/bin/python -m pip --quiet --disable-pip-version-check

.PHONY: demo test lint types check web clean

demo: $(VENV)/.installed  ## Segment the built-in motorcycle scene, as by default and as the paper
	$(VENV)/bin/geohue segment --sample motorcycle -o out/motorcycle/best
	$(VENV)/bin/geohue segment --sample motorcycle --preset paper -o out/motorcycle/paper
	@echo "The segments:        out/motorcycle/best/overlay.png beside out/motorcycle/paper/overlay.png"
	@echo "How sure a border is: out/motorcycle/best/borders.png"
	@echo "Q over the weight:    out/motorcycle/paper/weight_curve.png"

test: $(VENV)/.installed-dev  ## Run all tests
	$(VENV)/bin/python -m pytest

lint: $(VENV)/.installed-dev
	$(VENV)/bin/ruff check .
	$(VENV)/bin/ruff format --check .
	$(VENV)/bin/lint-imports

types: $(VENV)/.installed-dev
	$(VENV)/bin/mypy

check: lint types test

web: web/node_modules/.package-lock.json  ## Build the page of `geohue serve` from web/
	npm --prefix web run --silent build

web/node_modules/.package-lock.json: web/package.json web/package-lock.json
	npm --prefix web ci --silent

clean:
	rm -rf $(VENV) out build dist .mypy_cache .ruff_cache .pytest_cache .hypothesis

$(VENV)/bin/python:
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "geohue needs Python 3.11 or newer")'
	$(PYTHON) -m venv $(VENV)

$(VENV)/.installed: pyproject.toml | $(VENV)/bin/python
	$(PIP) install -e .
	@touch $@

$(VENV)/.installed-dev: pyproject.toml constraints.txt | $(VENV)/bin/python
	$(if $(LOCKED),$(PIP) install --require-hashes -r constraints.txt)
	$(PIP) install $(if $(LOCKED),--no-deps) -e '.[dev,clouds,datasets,ros,web]'
	@touch $@ $(VENV)/.installed

constraints.txt:  # make -B constraints.txt: the newest versions that pass together
	$(PYTHON) -m venv $(VENV)-lock
	$(VENV)-lock/bin/python -m pip --quiet install pip-tools
	$(VENV)-lock/bin/pip-compile --quiet --upgrade --generate-hashes --all-extras --strip-extras \
	  --allow-unsafe --no-header --no-annotate --no-emit-index-url --no-emit-find-links \
	  --no-emit-trusted-host --no-emit-options -o $@ pyproject.toml
	rm -rf $(VENV)-lock
