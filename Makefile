# make demo: install everything and run a demonstration.  make test: install everything, check and test.
.PHONY: demo test lint types trials bench wheel setup clean

BIN := .venv/bin

demo: setup
	@$(BIN)/libgz demo

test: lint types
	@$(BIN)/pytest -q -n 2 -m "not trial"

lint: setup
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check -q .

# From another directory, so that mypy checks the installed package with interfaces and models.
types: setup
	@cd build && ../$(BIN)/mypy --config-file ../pyproject.toml -p libgz

trials: setup
	@$(BIN)/pytest -q -m trial

bench: setup
	@for figures in step robots ground wire camera plugins sdf; do $(BIN)/python benchmarks/$$figures.py || exit 1; done

# A wheel with ODE, for any Linux of this architecture: dist/libgz-*.whl
wheel: setup
	@$(BIN)/python scripts/make_wheel.py

setup:
	@./scripts/setup.sh

clean:
	rm -rf .venv build dist *.egg-info .mypy_cache .pytest_cache .ruff_cache .hypothesis
