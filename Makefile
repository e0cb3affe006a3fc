# Two commands do everything: `make quickstart` and `make test`. Both set up .venv by themselves.
PYTHON ?= python3
BIN := .venv/bin
PIP := $(BIN)/pip install --disable-pip-version-check -q -c constraints.txt
RUN := runs/quickstart
ENVIRONMENTS := cover doors stick_button coffee
.DEFAULT_GOAL := help
.PHONY: help quickstart test slow check docs dist pddl-out benchmark benchmark-planners

help:
	@echo "make quickstart          learn Cover, export PDDL, plan with pyperplan, show the result"
	@echo "make test                all gates: ruff, mypy, pytest"
	@echo "make slow                the tests that take longer"
	@echo "make check               the gates without the tests"
	@echo "make docs                the pages, in docs/_build/html"
	@echo "make dist                wheel and source distribution, in dist/, checked"
	@echo "make pddl-out            make pddl_out/ again"
	@echo "make benchmark           both presets, learned and oracle skills: makes docs/benchmark.md; hours"
	@echo "make benchmark-planners  every planner on the problems in pddl_out and tests/data; makes docs/planners.md"

.venv/bin/pip:
	$(PYTHON) -m venv .venv

.venv/.user: .venv/bin/pip pyproject.toml constraints.txt
	$(PIP) -e .
	@touch $@

.venv/.dev: .venv/bin/pip pyproject.toml constraints.txt
	$(PIP) -e '.[dev]'
	@touch $@ .venv/.user

quickstart: .venv/.user
	@echo "== 1/5 demonstrations: the oracle solves 1000 training tasks"
	$(BIN)/bpns demos cover --count 1000 --seed 0 --out $(RUN)/demos.h5 --overwrite
	@echo "== 2/5 learning: operators, policies, samplers"
	$(BIN)/bpns learn $(RUN)/demos.h5 --out $(RUN)/model --workers 2 --overwrite
	@echo "== 3/5 evaluation: 50 new tasks"
	$(BIN)/bpns evaluate $(RUN)/model
	@echo "== 4/5 PDDL: the learned domain and ten problems"
	$(BIN)/bpns export $(RUN)/model --out $(RUN)/pddl --overwrite
	$(BIN)/bpns plan $(RUN)/pddl/domain.pddl --problem $(RUN)/pddl/p03.pddl --planner pyperplan --plans 2
	@echo "== 5/5 a refined plan, carried out in the simulator"
	$(BIN)/bpns plan $(RUN)/model --task 2 --planner pyperplan --show $(RUN)/plan.gif
	@echo
	@echo "Look at $(RUN)/plan.gif, read and edit $(RUN)/model/domain.pddl, and plan again."

check: .venv/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

test: check
	$(BIN)/pytest -n 2 -m "not slow"

slow: .venv/.dev
	$(BIN)/pytest -n 2 -m slow

docs: .venv/.dev
	$(BIN)/sphinx-build -q -W -E -b html docs docs/_build/html
	@echo "docs/_build/html/index.html"

dist: .venv/.dev
	rm -rf dist
	$(BIN)/python -m build --no-isolation
	$(BIN)/twine check --strict dist/*

pddl-out: .venv/.user
	@for e in $(ENVIRONMENTS); do \
		$(BIN)/bpns demos $$e --count 1000 --seed 0 --out runs/pddl-out/$$e.h5 --overwrite && \
		$(BIN)/bpns learn runs/pddl-out/$$e.h5 --out runs/pddl-out/$$e --workers 2 --overwrite && \
		$(BIN)/bpns export runs/pddl-out/$$e --out pddl_out/$$e --problems 10 --overwrite || exit 1; \
	done

benchmark: .venv/.user
	$(PIP) -e '.[plots]'
	$(BIN)/python benchmarks/benchmark.py
	$(BIN)/python benchmarks/simulate.py
	$(BIN)/python benchmarks/first_plan.py stick_button:test_buttons=10 coffee:test_cups=10 doors:rows=10:columns=10

benchmark-planners: .venv/.dev
	$(PIP) -e '.[planners]'
	$(BIN)/python benchmarks/planners.py --out docs/planners.md
	$(BIN)/python benchmarks/first_plan.py pddl_out/cover --repeat 20 --allowed 0.005
