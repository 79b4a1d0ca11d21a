# One command each: `make silo` (the main job), `make test` (the tests), `make bench` (speed).
PYTHON ?= python3.11
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready

.PHONY: setup silo four-cases noise element-tests study-biaxial stability chart paper paper-check docs docs-serve test test-long bench parts start scale endurance lint types clean

setup: $(READY)

# exactly what requirements.lock names, each file of it by its hash, and nothing else (setuptools, which venv brings, only
# where the fork of Taichi needs it); $(READY) says from which lock
$(READY): pyproject.toml requirements.lock
	$(PYTHON) -m venv --clear $(VENV)
	$(BIN)/python -m pip install -qq --require-hashes --only-binary :all: -r requirements.lock
	$(BIN)/python -c "import quadrants" 2>/dev/null || $(BIN)/python -m pip uninstall -qq --yes setuptools
	$(BIN)/python -m pip install -qq --no-deps --no-build-isolation --editable .
	cp requirements.lock $(READY)

LOCKING := build/locking
.PHONY: lock audit trust test-bare

# requirements.lock anew from pyproject.toml; versions stay if they can (`make lock RENEW=--upgrade`: the newest ones)
lock:
	$(PYTHON) -m venv $(LOCKING)
	$(LOCKING)/bin/python -m pip install -qq "uv>=0.9,<1"
	$(LOCKING)/bin/uv pip compile -q pyproject.toml --all-extras --no-emit-package taichi-silo --universal \
		--python-version 3.11.5 --generate-hashes --no-annotate --no-emit-index-url \
		--custom-compile-command "make lock" $(RENEW) --output-file requirements.lock

# licences of all that is installed, and what the databases of the network know against what requirements.lock names;
# without the network it fails. CVE-2026-95897 is of dask.array.from_npy_stack, which nothing here calls.
audit: $(READY)
	$(BIN)/pip-licenses
	$(BIN)/pip-audit --strict --disable-pip --requirement requirements.lock --ignore-vuln CVE-2026-95897

# dense sand between very rough walls: film, force curves, figures (some minutes)
silo: $(READY)
	$(BIN)/python scenarios/mass_flow.py

# the paper's four mass flows side by side
four-cases: $(READY)
	$(BIN)/python -m validation.four_cases

# what noise does to the wall force
noise: $(READY)
	$(BIN)/python -m validation.noise_control

# element tests of the paper (figures 1 and 2) through the law and through the method
element-tests: $(READY)
	$(BIN)/python -m validation.element_tests

# plane strain compression: every study of the paper's section 5 (figures 4 to 8), and more
study-biaxial: $(READY)
	$(BIN)/python -m validation.biaxial --study all

# where each variant of the method fails: table, figures, page
stability: $(READY)
	$(BIN)/python -m validation.stability

# speed against accuracy: error and cost of every dial (short; `--full` takes hours)
chart: $(READY)
	$(BIN)/python -m validation.accuracy

# all silo flows of the paper (figures 10 to 22), and the table of its statements (half an hour on one core)
paper: $(READY)
	$(BIN)/python -m validation.paper

# the paper's statements on silo flow against the runs in outputs/paper (seconds)
paper-check: $(READY)
	$(BIN)/python -m validation.paper.recheck

# the documentation, in site/: open site/index.html
docs: $(READY)
	$(BIN)/python -m mkdocs build --strict

# the same at http://127.0.0.1:8000, built anew whenever a page changes
docs-serve: $(READY)
	$(BIN)/python -m mkdocs serve --strict

# the default suite, some minutes on two cores; it says how much of the package it runs through
test: $(READY) test-bare
	$(BIN)/python -m pytest --cov --cov-report=
	@echo "$$($(BIN)/coverage report --format=total) % of the package's lines were run"

# the command line on a bare machine: LANG=C, no HOME, standard output closed (a minute or two)
test-bare: $(READY)
	env -u HOME LANG=C LC_ALL=C $(BIN)/python -m pytest tests/unit/test_program.py tests/unit/test_closed_output.py

# what takes minutes each: kills, full disks and hostile files one by one, long flows, all kinds of silo
test-long: $(READY)
	$(BIN)/python -m pytest -m long

# the table of what has been tried (docs/validation/trust.md), from the tests that count it (half an hour)
trust: $(READY)
	$(BIN)/python -m pytest -m "" -p tests.trust_table --trust-table docs/data/trust.csv

bench: $(READY)
	$(BIN)/python -m benchmarks.bench

# what each part of the method costs, and what it changes in P, T and N (some minutes)
parts: $(READY)
	$(BIN)/python -m benchmarks.parts

# what a start costs, in processor seconds (a minute or two)
start: $(READY)
	$(BIN)/python -m benchmarks.start

# memory and time of a silo of any size (a minute; Linux)
scale: $(READY)
	$(BIN)/python -m benchmarks.scale

# what long runs do: drift, memory, emptying and filling again (MINUTES of the paper's own speed, 30 if not given)
endurance: $(READY)
	$(BIN)/python -m benchmarks.endurance --minutes $(or $(MINUTES),30)

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

# types of the package (settings in pyproject.toml)
types: $(READY)
	$(BIN)/mypy

clean:
	rm -rf $(VENV) build site *.egg-info
