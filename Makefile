# make demo: install what it needs and run a demonstration.  make test: install the rest, check and test.
.PHONY: demo test tests check lint types trials fuzz bench bench-more docs wheel setup clean

BIN := .venv/bin

demo:
	@./scripts/setup.sh view
	@$(BIN)/libgz demo

test: lint
	@./scripts/install_chromium.sh
	@./scripts/install_compilers.sh
	@$(MAKE) --no-print-directory -j 2 types tests

tests: setup
	@$(BIN)/pytest -q -n 3 --dist worksteal -m "not trial"

# While working: the tests of what differs from BASE only.
BASE := main
check: lint types
	@tests=$$($(BIN)/python scripts/changed_tests.py --base $(BASE)); [ -z "$$tests" ] || \
		$(BIN)/pytest -q -n 3 --dist worksteal -m "not trial" $$tests

lint: setup
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check -q .
	@./scripts/check_client.sh

# From another directory, so that mypy checks the installed package with interfaces and models.
types: setup
	@cd build && ../$(BIN)/mypy --config-file ../pyproject.toml -p libgz

trials: setup
	@$(BIN)/python -c "import cosmic_ray" 2>/dev/null || $(BIN)/pip install --quiet -r tests/trials/requirements.txt
	@$(BIN)/pytest -q -m trial

# MINUTES for each reader; READER=stl for one; FILE=... gives a finding to the reader again.
fuzz: setup
	@$(BIN)/python -c "import atheris" 2>/dev/null || $(BIN)/pip install --quiet -r tests/fuzz/requirements.txt
	@PYTHONPATH=tests $(BIN)/python -m fuzz $(if $(MINUTES),--minutes $(MINUTES)) $(if $(READER),--reader $(READER)) $(if $(FILE),--file $(FILE))

# One table with aims; FIGURES="gazebo legs" for some of it.
bench: setup
	@$(BIN)/python benchmarks/figures.py $(FIGURES)

# All other benchmarks.
bench-more: setup
	@for part in step lock ground wire hostile player observer record camera plugins classic cxx sdf view state gym scale idle; do $(BIN)/python benchmarks/$$part.py || exit 1; done

# The documents as a site, offline: build/site/index.html
docs: setup
	@$(BIN)/python scripts/make_docs.py build/docs
	@$(BIN)/sphinx-build -q -W --keep-going -E -a -c docs build/docs build/site
	@echo "build/site/index.html"

# A wheel with ODE, for any Linux of this architecture: dist/libgz-*.whl
wheel: setup
	@$(BIN)/python scripts/make_wheel.py

setup:
	@./scripts/setup.sh dev

clean:
	rm -rf .venv build dist *.egg-info .mypy_cache .pytest_cache .ruff_cache .hypothesis .fuzz
