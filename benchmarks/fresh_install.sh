#!/usr/bin/env bash
# From nothing to a plan: build the wheel, install it into a new environment, run the first steps beside a folder envs/.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
mkdir envs cli learning symbolic
for name in envs cli learning symbolic; do echo 'MINE = True' > "$name/__init__.py"; done
"${PYTHON:-python3}" -m venv "$folder/.venv"
"$folder/.venv/bin/pip" install -q build hatchling editables
"$folder/.venv/bin/python" -m build -q --no-isolation --wheel -o "$folder/dist" "$root" > /dev/null
start=$(date +%s)
"$folder/.venv/bin/pip" install -q -c "$root/constraints.txt" "$folder"/dist/*.whl
echo "installed in $(($(date +%s) - start)) s"
cat > first.py <<'PYTHON'
import time
start = time.perf_counter()
import bpns
print(f"import bpns: {time.perf_counter() - start:.3f} s")
world = bpns.load_environment("stick_button:test_buttons=5")
demos = bpns.collect(world, count=200, seed=0)
model = bpns.learn(world, demos, seed=0)
model.save("model"); model = bpns.load_model("model")
print(model.operators["Op0"])
outcome = model.plan(world.task("test", 3), planner="pyperplan", timeout=60)
print(outcome, outcome.plan and outcome.plan.steps[:2], len(outcome.states), len(outcome.actions), outcome.why)
table = bpns.evaluate(model, tasks=50, seeds=range(3))
print(repr(table), len(table.rows))
bpns.export(model, "pddl", problems=1)
for number, abstract in zip(range(3), bpns.abstract_plans("pddl/domain.pddl", "pddl/p01.pddl", planner="astar")):
    print(number, abstract)
import envs
assert envs.MINE and "site-packages" in bpns.__file__
print(f"all: {time.perf_counter() - start:.1f} s")
PYTHON
"$folder/.venv/bin/python" first.py
cd / && "$folder/.venv/bin/bpns" plan "$folder/model" --task 1 | grep executed
