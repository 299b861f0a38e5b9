# Every target makes its own virtual environment when it needs one: Python 3.11 or newer and make are enough.
#   PYTHON=python3.12   another interpreter        VENV=.venv   where the environment is        OUT=demo   where the demo writes

PYTHON ?= python3
VENV ?= .venv
OUT ?= demo

RUN := $(VENV)/bin/python
INSTALL := $(RUN) -m pip install --quiet --disable-pip-version-check --editable

.DEFAULT_GOAL := help
.PHONY: help demo test test-long test-petsc test-pardiso coverage mutants lint types bench docs docs-full verification measured corpus

help:
	@echo "make demo       run the main example: audit, picture, animation, result file, in $(OUT)/"
	@echo "make test       run the tests"
	@echo "make test-long  run the long checks (minutes)"
	@echo "make coverage   the tests, and which lines and branches they reach"
	@echo "make mutants    change the mechanics here and there and see whether tests notice (hours; COUNT=60 SEED=1 LOG=FILE)"
	@echo "make test-petsc run the checks of PETSc on two processes (Debian's python3-petsc4py and openmpi-bin)"
	@echo "make test-pardiso  run the checks of PARDISO (installs MKL, 1 GB)"
	@echo "make lint       ruff: rules and format"
	@echo "make types      pyright, strict"
	@echo "make bench      print the speed of this machine"
	@echo "make docs       the pages, in docs/_build/html/, without running the gallery"
	@echo "make docs-full  the same with the gallery's pictures (minutes)"

demo: $(VENV)/.plot
	@$(VENV)/bin/directrix run src/directrix/cases/free_flight.toml --beside midpoint --out $(OUT)

test: $(VENV)/.dev
	@$(RUN) -m pytest

test-long: $(VENV)/.dev
	@$(RUN) -m pytest -m slow

# two gates: pytest-cov knows one figure for lines and branches together
coverage: $(VENV)/.dev
	@DIRECTRIX_CACHE_DIR="$$(mktemp -d)" $(RUN) -m pytest --cov --cov-report=json --cov-report=term:skip-covered
	@$(RUN) -c "import json; t = json.load(open('coverage.json'))['totals']; \
	lines, branches = t['covered_lines'] / t['num_statements'], t['covered_branches'] / t['num_branches']; \
	print(f'lines {lines:.1%} (95 % asked), branches {branches:.1%} (90 % asked)'); \
	raise SystemExit(not (lines >= 0.95 and branches >= 0.90))"

mutants: $(VENV)/.dev
	@$(RUN) tools/mutants.py --count $(or $(COUNT),60) --seed $(or $(SEED),1) $(if $(LOG),--log $(LOG))

# Debian's PETSc goes with the system's Python and a NumPy before 2
PETSC_DIR ?= $(lastword $(wildcard /usr/lib/petscdir/petsc*/*-real))
test-petsc:
	@test -d .venv-petsc || { /usr/bin/python3 -m venv --system-site-packages .venv-petsc && \
		.venv-petsc/bin/pip install --quiet --disable-pip-version-check "numpy<2" pytest hypothesis --editable .; }
	@PETSC_DIR=$(PETSC_DIR) OMP_NUM_THREADS=1 mpirun --allow-run-as-root --oversubscribe -n 2 \
		.venv-petsc/bin/python -m pytest -p no:cacheprovider -m petsc tests/test_petsc.py

# MKL is too large for everyone's environment
test-pardiso:
	@test -d .venv-pardiso || { $(PYTHON) -m venv .venv-pardiso && \
		.venv-pardiso/bin/pip install --quiet --disable-pip-version-check pytest hypothesis --editable ".[rslab,pardiso]"; }
	@.venv-pardiso/bin/python -m pytest -p no:cacheprovider tests/test_direct.py

lint: $(VENV)/.dev
	@$(RUN) -m ruff check
	@$(RUN) -m ruff format --check

types: $(VENV)/.dev
	@$(RUN) -m pyright --pythonpath $(RUN)

bench: $(VENV)/.plot
	@for file in benchmarks/[!_]*.py; do echo "== $$file"; $(RUN) "$$file" || exit 1; done

SPHINX = $(RUN) -m sphinx -W --keep-going -q -d docs/_build/doctrees docs docs/_build/html

docs: $(VENV)/.docs
	@$(SPHINX) -D plot_gallery=0
	@echo "docs/_build/html/index.html"

docs-full: $(VENV)/.docs
	@$(SPHINX)
	@echo "docs/_build/html/index.html"

# --- what is written by programs and kept: the tables of docs/, and the files of tests/corpus/

verification: $(VENV)/.plot
	@mkdir -p docs/_build
	@$(VENV)/bin/directrix verify --json docs/_build/rows.json > docs/_build/verify.txt
	@$(RUN) docs/_verification.py docs/_build/rows.json

measured: $(VENV)/.plot
	@$(RUN) docs/measure.py

corpus: $(VENV)/.plot
	@$(RUN) tests/corpus/write.py

# --- environments: a stamp each, older than pyproject.toml means install again

# also old interpreters have to understand this
define FIT
import sys
if sys.version_info < (3, 11):
    sys.exit("directrix needs Python 3.11 or newer; %s is %d.%d.\n  fix: name another one, for example 'make demo PYTHON=python3.12'"
             % (sys.executable, sys.version_info[0], sys.version_info[1]))
try:
    import ensurepip, venv
except ImportError:
    sys.exit("%s cannot make virtual environments: its venv module is not installed.\n  fix: install it (Debian and Ubuntu: "
             "apt install python3-venv), or name another one, for example 'make demo PYTHON=python3.12'" % sys.executable)
endef
export FIT

$(VENV)/.made:
	@command -v "$(PYTHON)" >/dev/null || { echo "there is no '$(PYTHON)'.  fix: install Python 3.11 or newer, or name one, \
	for example 'make demo PYTHON=/usr/local/bin/python3.12'" >&2; exit 1; }
	@$(PYTHON) -c "$$FIT"
	@$(PYTHON) -m venv $(VENV)
	@touch $@

$(VENV)/.plot: pyproject.toml $(VENV)/.made
	@echo "installing directrix into $(VENV) (once, less than a minute) ..."
	@$(INSTALL) ".[plot]"
	@touch $@

$(VENV)/.dev: pyproject.toml $(VENV)/.made
	@echo "installing directrix and its tools into $(VENV) (once, less than a minute) ..."
	@$(INSTALL) ".[dev]"
	@touch $@

$(VENV)/.docs: pyproject.toml $(VENV)/.made
	@echo "installing directrix and what builds its pages into $(VENV) (once, less than a minute) ..."
	@$(INSTALL) ".[docs]"
	@touch $@
