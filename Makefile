# One command each: `make silo` (the main job), `make test` (the tests), `make bench` (speed).
PYTHON ?= python3.11
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready

.PHONY: setup silo four-cases noise test test-long bench lint clean

setup: $(READY)

$(READY): pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install -qq --upgrade pip
	$(BIN)/python -m pip install -qq --editable ".[dev]"
	touch $(READY)

# dense sand between very rough walls: film, force curves, figures (some minutes)
silo: $(READY)
	$(BIN)/python scenarios/mass_flow.py


# the paper's four mass flows side by side
four-cases: $(READY)
	$(BIN)/python scenarios/four_cases.py

# what noise does to the wall force
noise: $(READY)
	$(BIN)/python scenarios/noise_control.py

test: $(READY)
	$(BIN)/python -m pytest

test-long: $(READY)
	$(BIN)/python -m pytest -m long

bench: $(READY)
	$(BIN)/python -m benchmarks.bench

lint: $(READY)
	$(BIN)/ruff check .

clean:
	rm -rf $(VENV) build *.egg-info
