# Set-up and daily commands; needs only make and python3 (3.11 or newer, with venv). `make help` lists them.
# Everything is installed into .venv and built into build/; stamp files keep a second run from installing again.

PYTHON ?= python3
PYTEST_ARGS ?=

VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet
MADE := $(VENV)/made.stamp
BUILD := $(VENV)/build.stamp
RUN := $(VENV)/run.stamp
DEV := $(VENV)/dev.stamp
PAGE := $(VENV)/page.stamp
KERNELS := $(VENV)/kernels.stamp

# A file of tests stays with one worker, so that what it makes is made once; tests/conftest.py puts the longest first.
# Three workers, also on two cores: those with a browser wait much of their time.
SUITE = OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n 3 --dist loadfile --no-loadscope-reorder

# The page's JavaScript and the tests of its modules.
JS := src/percuss/web/page tests/web/modules
LAID_OUT := $(JS:%="%/**/*.js")
TOOLS := PATH="$(CURDIR)/$(BIN):$$PATH" $(VENV)/js/node_modules/.bin
PRETTIER := $(TOOLS)/prettier --print-width 120 --log-level warn

# The suite starts hundreds of processes; without bytecode beside the sources each would compile the package again.
export PYTHONDONTWRITEBYTECODE =

.DEFAULT_GOAL := help
.PHONY: help demo ready test slow lint page format docs bench wheel pins clean

help:  ## show this list
	@awk -F ':.*## ' '/^[a-z]+:.*## / { printf "  make %-8s %s\n", $$1, $$2 }' Makefile

demo: $(RUN)  ## two sample hammers: one under a measured history, one that switches its own valve; reports and pictures
	@rm -rf build/demo && mkdir -p build/demo
	$(BIN)/percuss new hydraulic-drifter -o build/demo/drifter.toml
	$(BIN)/percuss steady build/demo/drifter.toml --plot build/demo/drifter.png
	$(BIN)/percuss new valve-breaker -o build/demo/breaker.toml
	$(BIN)/percuss machine build/demo/breaker.toml --plot build/demo/breaker.png

test: ready  ## run the suite: the page in a browser and the examples of the documentation too, all but `make slow`
	$(SUITE) -m "not slow" $(PYTEST_ARGS)

slow: ready  ## run the tests that take long: many more first contacts, a server under load, the audit of the claims, workers killed
	$(SUITE) -m slow $(PYTEST_ARGS)

ready: $(RUN)
	@$(MAKE) -s $(if $(findstring jobserver,$(MAKEFLAGS)),,-j2) $(DEV) $(KERNELS)

lint: $(DEV)  ## ruff (rules and layout), mypy strict, import contracts; and the page
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-logo
	@$(MAKE) page

page: $(PAGE)  ## the page's JavaScript alone: oxlint, prettier, types
	$(BIN)/oxlint --deny-warnings $(JS)
	$(PRETTIER) --check $(LAID_OUT)
	$(TOOLS)/tsc

format: $(DEV) $(PAGE)  ## lay the code out with ruff, that of the page with prettier
	$(BIN)/ruff format .
	$(PRETTIER) --write $(LAID_OUT)
	$(BIN)/ruff check --fix .

docs: $(DEV)  ## build the documentation into build/docs
	$(BIN)/sphinx-build -W --keep-going -q -b html -d build/doctrees docs build/docs
	@echo "build/docs/index.html"

bench: $(DEV)  ## measure the speeds that the package promises; COMPARE=REF: beside another commit, fails where 5 % worse
	$(BIN)/python benchmarks/run.py $(COMPARE:%=--compare %)

wheel: $(RUN)  ## the wheel into dist/, with machine code of the kernels for x86-64-v3, so that nobody waits for a compiler
	PERCUSS_MACHINE_CODE=1 $(PIP) wheel --no-deps --no-build-isolation -w dist .

pins:  ## compile requirements/*.txt from pyproject.toml again (needs uv)
	sh requirements/compile.sh

clean:  ## remove .venv, build/ and the tools' caches
	rm -rf $(VENV) build dist docs/auto_gallery .hypothesis .import_linter_cache .mypy_cache .pytest_cache .ruff_cache
	find src tests docs benchmarks -name __pycache__ -type d -prune -exec rm -rf {} + 2>/dev/null || true

$(MADE):
	@$(PYTHON) -c 'import sys; sys.version_info >= (3, 11) or sys.exit(1)' || { \
	  echo "percuss needs Python 3.11 or newer, and '$(PYTHON)' is $$($(PYTHON) --version 2>&1);" \
	       "name another one: make PYTHON=python3.12 $(MAKECMDGOALS)" >&2; exit 1; }
	@echo "making $(VENV) (first use; the packages come from PyPI and take a minute)"
	@$(PYTHON) -m venv $(VENV) || { \
	  echo "'$(PYTHON) -m venv' failed; on Debian and Ubuntu: apt install python3-venv" >&2; rm -rf $(VENV); exit 1; }
	@touch $@

$(BUILD): requirements/build.txt $(MADE)
	@echo "installing requirements/build.txt"
	@$(PIP) install --require-hashes -r requirements/build.txt
	@touch $@

$(RUN): requirements/run.txt pyproject.toml $(BUILD)
	@echo "installing requirements/run.txt and percuss"
	@$(PIP) install --require-hashes -r requirements/run.txt
	@$(PIP) install --no-deps --no-build-isolation -e .
	@touch $@

$(DEV): requirements/dev.txt $(RUN)
	@echo "installing requirements/dev.txt"
	@$(PIP) install --require-hashes -r requirements/dev.txt
	@touch $@

$(PAGE): requirements/page.txt requirements/package.json requirements/package-lock.json $(BUILD)
	@echo "installing requirements/page.txt, and TypeScript and prettier of requirements/package.json"
	@$(PIP) install --require-hashes -r requirements/page.txt
	@mkdir -p $(VENV)/js && cp requirements/package.json requirements/package-lock.json $(VENV)/js
	@cd $(VENV)/js && PATH="$(CURDIR)/$(BIN):$$PATH" npm ci --loglevel error --no-audit --no-fund --ignore-scripts >/dev/null
	@touch $@

# Once, beside the installation above: else each process of the suite would compile them for itself.
$(KERNELS): $(wildcard src/percuss/blow/kernels/*.py src/percuss/simulate/kernels/*.py src/percuss/stability/*_kernels.py src/percuss/steady/periodic/kernels/*.py src/percuss/steady/self_excited/*_kernels.py src/percuss/mechanics/*_kernels.py) src/percuss/explore/tangent.py $(RUN)
	@echo "compiling the kernels"
	@if $(BIN)/python -c 'import sys; from percuss.web.workers import load; sys.exit(not load())' \
	    > $(VENV)/kernels.log 2>&1; then touch $@; \
	  else echo "the kernels could not be compiled; the tests will say more" >&2; fi
