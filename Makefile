# Two commands do everything on a fresh machine: `make demo` and `make test`.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
SECONDS := 30
PIP := $(BIN)/pip install --quiet --disable-pip-version-check --constraint constraints.txt
SOURCES := pyproject.toml constraints.txt CMakeLists.txt $(wildcard src/thenar/_native/*.cpp src/thenar/_native/*.hpp)

.PHONY: demo test lint bench bench-micro docs wheel sanitize fuzz clean

demo: $(VENV)/.package
	$(BIN)/thenar run glr

test: $(VENV)/.dev
	$(BIN)/python -m pytest

lint: $(VENV)/.dev
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(VENV)/.dev
	$(BIN)/python -m bench

bench-micro: $(VENV)/.dev
	$(BIN)/python -m pytest bench/test_micro.py --benchmark-timer=time.process_time

docs: $(VENV)/.dev
	$(BIN)/python docs/pictures.py

wheel: $(VENV)/.dev
	$(BIN)/python -m build

# The kernel's tests with the address and undefined-behaviour sanitizers, in an environment of their own.
sanitize: $(VENV)/.dev
	bash tests/sanitize.sh

# Every reader of model files, each for SECONDS: make fuzz SECONDS=600.  What is found is kept in out/fuzz.
fuzz: $(VENV)/.fuzz
	$(BIN)/python -m tests.fuzz --seconds $(SECONDS)

clean:
	rm -rf $(VENV) build dist

$(VENV)/.package: $(SOURCES)
	@$(PYTHON) tools/check_machine.py
	$(PYTHON) -m venv $(VENV)
	$(PIP) --editable .
	@touch $@

$(VENV)/.dev: $(VENV)/.package
	$(PIP) --editable '.[dev]'
	@touch $@

$(VENV)/.fuzz: $(VENV)/.dev
	$(PIP) --editable '.[fuzz]'
	@touch $@
