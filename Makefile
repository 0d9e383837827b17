# Everything runs in .venv. The demonstration fills it from requirements.txt, with what running needs; `make setup`, which
# all other targets call, from requirements-dev.txt, with what tests, linters and pages need too.

VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.runs
READY_FOR_DEV := $(VENV)/.set-up
READY_FOR_BENCH := $(VENV)/.set-up-bench
# Installing is mute, which looks like one that hangs: a line every five seconds says how far it is.
INSTALL := VENV=$(VENV) .ci/with-progress .ci/install
PACKAGES := cartgrasp estimation planning

# The matrices are tiny, so threads inside BLAS only cost; nothing here may open a window; and bytecode is kept, since each
# process would compile all that it imports.
ENV := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MPLBACKEND=Agg PYTHONDONTWRITEBYTECODE=

# The first of these that is 3.11 or newer makes .venv (`make setup PYTHON=...` names another).
PYTHON := python3 python3.11 python3.12 python3.13

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help setup demo test test-quick test-other prove sealed floors measured lint format docs bench lock clean

help:
	@echo "make setup    make .venv from the lock, with what tests and linters need, and cartgrasp, editable"
	@echo "make demo     run the demonstration; its pages go to out/demo"
	@echo "make test     run the tests"
	@echo "make test-quick  of these what takes little, of the library alone: for daily work"
	@echo "make test-other  the same on another Python, in .venv-other (PYTHON=python3.13)"
	@echo "make prove    run the long proofs that make test leaves out"
	@echo "make sealed   name effects hidden in generated logs, and score what was named (SEEDS=0:4; hours)"
	@echo "make floors   from which share of its usual size on an effect is named (SEEDS, SHARES; hours)"
	@echo "make measured logs that nobody here made, and variants of them, beside what is known of them (DATA=...; an hour)"
	@echo "make lint     ruff check, ruff format --check, mypy --strict"
	@echo "make format   let ruff format and mend what it can"
	@echo "make docs     build the documentation into out/docs"
	@echo "make bench    run the benchmarks (installs a few more solvers)"
	@echo "make lock     resolve pyproject.toml anew into the lock files (LOCKFLAGS=--upgrade for newer versions)"
	@echo "make clean    remove outputs and caches (.venv stays)"

setup: $(READY_FOR_DEV)

$(READY): requirements.txt pyproject.toml | $(BIN)/pip
	@echo "Installing what requirements.txt pins ..."
	@$(INSTALL) --require-hashes -r requirements.txt
	@$(INSTALL) --no-deps --no-build-isolation -e .
	@touch $@

$(READY_FOR_DEV): requirements-dev.txt $(READY)
	@echo "Installing what requirements-dev.txt pins ..."
	@$(INSTALL) --require-hashes -r requirements-dev.txt
	@touch $@

$(READY_FOR_BENCH): requirements-bench.txt $(READY_FOR_DEV)
	@$(INSTALL) --require-hashes -r requirements-bench.txt
	@touch $@

$(BIN)/pip:
	@echo "Making $(VENV) ..."
	@python=; \
	for name in $(PYTHON); do \
	    $$name -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && python=$$name && break; \
	done; \
	if [ -z "$$python" ]; then \
	    echo "No Python 3.11 or newer among: $(PYTHON). Install python3.11, or name one: make setup PYTHON=..." >&2; \
	    exit 1; \
	fi; \
	can_make_venv() { $$python -c 'import ensurepip, venv' 2>/dev/null; }; \
	if ! can_make_venv && command -v apt-get >/dev/null; then \
	    package=$${python##*/}-venv; \
	    if [ "$$(id -u)" = 0 ]; then sudo=; else sudo="sudo -n"; fi; \
	    echo "Installing $$package, which this Python needs to make .venv ..."; \
	    { $$sudo apt-get update -qq && $$sudo apt-get install -y -qq $$package; } || true; \
	fi; \
	if ! can_make_venv; then \
	    echo "$$python can't make a virtual environment: install its venv module (Debian: $${python##*/}-venv)." >&2; \
	    exit 1; \
	fi; \
	$$python -m venv $(VENV)

demo: $(READY)
	$(ENV) $(BIN)/cartgrasp demo --out out/demo

test: setup
	$(ENV) $(BIN)/cartgrasp warm-up
	$(ENV) $(BIN)/python -m pytest -n 2 --dist=worksteal

# Commands, pages, studies and benchmarks have folders of their own.
OF_THE_LIBRARY := $(addprefix tests/,core effects estimation logs planning simulation test_architecture.py test_mistakes.py test_writing.py)
test-quick: setup
	$(ENV) $(BIN)/python -m pytest -n 2 --dist=worksteal -m "not prove and not long" $(OF_THE_LIBRARY)

test-other:
	$(MAKE) test-quick VENV=.venv-other PYTHON="$(PYTHON)"

# pytest's exit status 5 says that no test is marked `prove`.
prove: setup
	$(ENV) $(BIN)/python -m pytest -m prove tests || [ $$? -eq 5 ]

# Diagnoses that are there are kept, so what was interrupted goes on; after a change of the workflow, remove them first.
# Logs that are rough on purpose, worse first guesses, proof: make sealed SEALED=out/rough OPTIONS="--cases rough"
# (`python -m benchmarks.sealed --help` says what there is).
SEEDS := 0:4
SHARES := 1,0.5,0.25,0.125
SEALED := out/sealed
OPTIONS :=
sealed: setup $(READY_FOR_BENCH)
	$(ENV) $(BIN)/python -m benchmarks.sealed generate --out $(SEALED) --seeds $(SEEDS) $(OPTIONS)
	$(ENV) $(BIN)/cartgrasp study discrepancy $(SEALED)
	$(ENV) $(BIN)/python -m benchmarks.true_structures $(SEALED)
	$(ENV) $(BIN)/python -m benchmarks.sealed score $(SEALED)
	@for method in err sindy everything sysid lisdd; do \
	    echo && echo "General method: $$method" && \
	    $(ENV) $(BIN)/python -m benchmarks.sealed baselines $(SEALED) --method $$method && \
	    $(ENV) $(BIN)/python -m benchmarks.true_structures $(SEALED) --reports out-$$method && \
	    $(ENV) $(BIN)/python -m benchmarks.sealed score $(SEALED) --reports out-$$method || exit 1; \
	done

FLOORS := out/floors
floors: setup $(READY_FOR_BENCH)
	$(ENV) $(BIN)/python -m benchmarks.sealed generate --out $(FLOORS) --seeds $(SEEDS) --cases single --shares $(SHARES)
	$(ENV) $(BIN)/cartgrasp study discrepancy $(FLOORS)
	$(ENV) $(BIN)/python -m benchmarks.sealed score $(FLOORS)

# Answers are kept by code, log and cart, so what was interrupted goes on. The data are no part of the project.
DATA := ../shared/data
MEASURED := out/measured
measured: setup
	$(ENV) $(BIN)/python -m benchmarks.measured --data $(DATA) --kept $(MEASURED) --out $(MEASURED)/measured.md $(MEASUREDFLAGS)

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy --strict $(PACKAGES) examples

format: setup
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

docs: setup
	$(ENV) $(BIN)/python -m sphinx -W --keep-going -n -q -b html docs out/docs
	@echo "Open out/docs/index.html"

bench: setup $(READY_FOR_BENCH)
	$(ENV) $(BIN)/python -m benchmarks

# An index that pip is told of is handed over; it isn't written into the locks.
COMPILE = $(BIN)/uv pip compile --quiet --universal --python-version 3.11 --fork-strategy fewest --generate-hashes \
    --no-emit-index-url --no-emit-find-links --custom-compile-command "make lock" $(LOCKFLAGS) pyproject.toml

lock: | $(BIN)/pip
	@[ -x $(BIN)/uv ] || $(BIN)/pip install -qq --disable-pip-version-check uv
	@index=$${PIP_INDEX_URL:-$$($(BIN)/pip config get global.index-url 2>/dev/null)}; \
	[ -z "$$index" ] || export UV_DEFAULT_INDEX="$$index"; \
	$(COMPILE) --group build -o requirements.txt && \
	$(COMPILE) --extra dev --extra docs --extra parquet --extra arms --extra rendering --extra dask \
	    --constraint requirements.txt -o requirements-dev.txt && \
	$(COMPILE) --extra bench --constraint requirements-dev.txt -o requirements-bench.txt && \
	grep -A 99 '^uv==' requirements-dev.txt | sed '1,/[^\\]$$/!d' | grep -v '# ' > .ci/uv.txt

clean:
	rm -rf out dist build .mypy_cache .ruff_cache .pytest_cache .hypothesis
	find . -name '.venv*' -prune -o -name __pycache__ -prune -exec rm -rf {} +
