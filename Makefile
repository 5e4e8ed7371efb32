# Two commands: `make demo` measures the small case in data/synthetic, `make test` runs the tests.
# Both set up everything they need in .venv; see docs/clean_machine.md.

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
STAMP  := $(VENV)/.installed
WORKERS ?= 2# processes that share the tests; 0: none but this one

.PHONY: setup demo test check bench format clean

setup: $(STAMP)

$(STAMP): pyproject.toml tools/setup.sh
	@PYTHON="$(PYTHON)" VENV="$(VENV)" sh tools/setup.sh
	@touch $(STAMP)

demo: $(STAMP)
	$(BIN)/shapemorph run configs/demo.yaml -o runs/demo
	@echo "report: runs/demo/report.html"

test: $(STAMP)
	$(BIN)/python -m pytest -q -n $(WORKERS) --dist loadfile

check: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

format: $(STAMP)
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

bench: $(STAMP)
	$(BIN)/python benchmarks/accuracy_table.py

clean:
	rm -rf runs .mypy_cache .ruff_cache .pytest_cache .import_linter_cache
