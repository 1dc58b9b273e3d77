# All commands need Python 3.11 or newer and make, nothing else.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# Of these the tests are run with all that have a wheel, and `make study` installs the first, numba;
# EXTRAS=campaign,sixdof leaves it out.
EXTRAS ?= fast,campaign,sixdof

.PHONY: study test suite thorough test-all other-processor coverage lint bench notebooks docs site packages release clean help

study: $(VENV)/.installed  ## set everything up and size configuration I
	$(BIN)/tvclin study configuration-i --wind triangular --duration 7.5 --peak-deg 5 --limit-deg 0.45

# Bytecode is kept whatever the environment says: workers, notebooks and commands begin many times.
test: export PYTHONDONTWRITEBYTECODE =
test: $(VENV)/.installed-dev  ## set everything up and pass the tests
	$(MAKE) --no-print-directory suite

# A worker that dies fails the run at once; begun anew, it leaves the others waiting for ever.
SUITE = $(BIN)/pytest -n auto --dist loadfile --no-loadscope-reorder --max-worker-restart 0 -q

# A worker for each core: with more threads of BLAS than one they wait for each other.
suite thorough: export OPENBLAS_NUM_THREADS = 1
suite:
	$(SUITE) -m "not thorough"

thorough: export PYTHONDONTWRITEBYTECODE =
thorough: $(VENV)/.installed-dev  ## what `make test` leaves out: more draws of its claims, every page and notebook
	$(SUITE) -m thorough --share=$$(($(DAY) % $(SHARES)))/$(SHARES) docs tests tvclin

# With SHARES=2 half of them, by turns, a day each.
SHARES := 1

test-all: lint test thorough  ## pass lint, the tests, the thorough ones, and half the numbers as on an older processor
	$(MAKE) --no-print-directory other-processor NUMBERS="$(HALF)"

# By turns, a day each; PROCESSOR=Prescott takes that one. The halves change when all had their turn.
DAY = $(shell $(PYTHON) -c 'import time; print(time.gmtime().tm_yday)')
NUMBERS := kernels numerics linear ascent boundary control flights
FIRST := kernels numerics linear control
HALF = $(if $(filter 0 1 2 3,$(shell echo $$(($(DAY) % 8)))),$(FIRST),$(filter-out $(FIRST),$(NUMBERS)))
PROCESSORS := Haswell Nehalem Prescott Sandybridge
PROCESSOR ?= $(word $(shell echo $$(($(DAY) % 4 + 1))),$(PROCESSORS))

other-processor: export PYTHONDONTWRITEBYTECODE =
other-processor: $(VENV)/.installed-dev  ## pass the chapters with numbers as on an older processor
	OPENBLAS_CORETYPE=$(PROCESSOR) NUMBA_CPU_NAME=generic \
	  $(SUITE) -m "not thorough" $(addprefix tests/,$(NUMBERS))

coverage: $(VENV)/.installed-dev  ## pass the tests and list the lines that none of them runs
	$(BIN)/python -m pip install --quiet --no-compile --group coverage
	$(BIN)/pytest -n auto --dist loadfile -q --cov=tvclin

lint: $(VENV)/.installed-dev  ## style, types and the import contracts
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(VENV)/.installed-dev  ## measure tvclin and its peers in one run, and print the ratios
	cd benchmarks && ../$(BIN)/python -m pytest -q -p no:xdist --rootdir . --benchmark-columns=min,mean .

notebooks: $(VENV)/.installed-dev  ## execute notebooks/*.py and write their .ipynb beside them
	$(BIN)/python notebooks/execute.py

docs: $(VENV)/.installed-docs  ## build the documentation as a site, docs/_build/html/index.html
	$(BIN)/sphinx-build --fail-on-warning --keep-going docs docs/_build/html

site: $(VENV)/.installed  ## build a site of notebooks that run in the browser, docs/_build/browser/index.html
	$(BIN)/python -m pip install --quiet --no-compile --group site
	$(BIN)/python notebooks/browser.py

packages:  ## install wheel and sdist with each extra alone and with the lowest versions, and try them
	$(PYTHON) .ci/packages.py

release:  ## build and check the files of a release; a dry run without TVCLIN_HOME=address of the repository
	$(PYTHON) .ci/release.py

clean:  ## remove the environment and all caches
	rm -rf $(VENV) .coverage .mypy_cache .pytest_cache .ruff_cache .import_linter_cache dist docs/_build docs/_generated
	rm -rf tvclin/kernels/__pycache__

help:  ## list the commands
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*##/:/'

$(VENV)/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
	  || { echo "tvclin needs Python 3.11 or newer; name one with: make PYTHON=python3.12 ..."; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --no-compile --upgrade pip

comma := ,
# Each by itself: where one has no wheel for a platform the others are installed all the same.
define INSTALL_EXTRAS
for extra in $(subst $(comma), ,$(1)); do \
  $(BIN)/python -m pip install --quiet --no-compile --only-binary numba,llvmlite,pyarrow,jsbsim \
    --editable ".[$$extra]" \
    || echo "the extra $$extra has no wheel for this platform; going on without it"; \
done
endef

# numba and slycot have wheels for the common platforms only; tvclin works without them, and without
# numba many answers take minutes.
$(VENV)/.installed: pyproject.toml | $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --no-compile --editable ".[report]"
	$(call INSTALL_EXTRAS,$(findstring fast,$(EXTRAS)))
	$(BIN)/python -m pip install --quiet --no-compile --only-binary slycot "slycot>=0.7" \
	  || echo "slycot has no wheel for this platform; going on without it"
	touch $@

$(VENV)/.installed-dev: $(VENV)/.installed
	$(BIN)/python -m pip install --quiet --no-compile --group test --group lint --editable ".[notebook,report]"
	$(call INSTALL_EXTRAS,$(EXTRAS))
	touch $@

$(VENV)/.installed-docs: $(VENV)/.installed
	$(BIN)/python -m pip install --quiet --no-compile --group docs
	$(call INSTALL_EXTRAS,$(EXTRAS))
	touch $@
