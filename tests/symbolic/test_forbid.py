from collections.abc import Callable
from itertools import chain
from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from bpns.symbolic.grounding.ground import Unreachable, ground
from bpns.symbolic.operators import Domain, Operator, Problem
from bpns.symbolic.pddl.read import read_domain, read_problem
from bpns.symbolic.pddl.rewriting.forbid import forbid
from bpns.symbolic.pddl.rewriting.portable import Rewritten, portable
from bpns.symbolic.pddl.write import write_domain, write_problem
from bpns.symbolic.planners.astar import AStar
from bpns.symbolic.planners.protocol import Limit, SearchRecord
from bpns.symbolic.structs import OBJECT, Object, Predicate, Variable
from tests.symbolic._problems import COVER, cover_problem
from tests.symbolic._rewriting import Plan, Step, plain_plans, rewritten_plans, rich_tasks

PLACE_TWO = portable(COVER, cover_problem(2), False, False)


def steps(text: str) -> Plan:
    """Read ``Pick block0 robby, Place block0 target0 robby``."""
    parts = [part.split() for part in text.split(",")]
    return tuple((name, tuple(objects)) for name, *objects in parts)


# ----------------------------------------------------------------------------------- brute force


@settings(max_examples=60)
@given(rich_tasks(), st.booleans(), st.booleans(), st.integers(0, 2**32 - 1))
def test_exactly_the_forbidden_plans_are_gone(
    task: tuple[Domain, Problem], negation: bool, typing: bool, seed: int
) -> None:
    before = plain_plans(*task)
    assume(before is not None and any(before[1:]))
    assert before is not None
    known = sorted(chain.from_iterable(before))
    gone = set(Random(seed).sample(known, min(len(known), 1 + seed % 6)))
    rewritten = forbid(portable(*task, negation, negation, typing), sorted(gone))
    if () in gone:
        assert rewritten is None
        return
    assert rewritten is not None
    after = rewritten_plans(rewritten, reachable=True)
    assert after is not None
    # There are no more paths than before: where the search ended earlier, nothing was left.
    after += [set() for _ in before[len(after) :]]
    assert after[: len(before)] == [layer - gone for layer in before]


# -------------------------------------------------------------------------- asking again and again

Ask = Callable[[Rewritten], Plan | None]


def ask_astar(task: Rewritten) -> Plan | None:
    """Return the first plan of our planner, in the words of the original task."""
    found = ground(task.domain, task.problem)
    if isinstance(found, Unreachable):
        return None
    record = SearchRecord()
    plans = AStar().plans(found, np.random.default_rng(0), Limit(20_000), record)
    plan = next(iter(plans), None)
    assert not record.stopped_by
    if plan is None:
        return None
    return tuple(task.original(s.operator.name, [o.name for o in s.objects]) for s in plan.steps)


def ask_pyperplan(task: Rewritten, folder: Path) -> Plan | None:
    """Return the plan that pyperplan itself finds in the files."""
    library = pytest.importorskip("pyperplan.planner")
    files = folder / "domain.pddl", folder / "problem.pddl"
    files[0].write_text(write_domain(task.domain))
    files[1].write_text(write_problem(task.problem, task.domain))
    grounded = library._ground(library._parse(*map(str, files)), remove_irrelevant_operators=False)
    found = library.SEARCHES["astar"](grounded, library.HEURISTICS["hmax"](grounded))
    return None if found is None else tuple(read_step(task, operator.name) for operator in found)


def ask_kairos(task: Rewritten) -> Plan | None:
    """Return the plan that kairos finds and proves optimal."""
    kairos = pytest.importorskip("kairos")
    result = kairos.solve(write_domain(task.domain), write_problem(task.problem, task.domain))
    if result.plan is None:
        return None
    return tuple(task.original(step.name, step.args) for step in result.plan.steps)


def read_step(task: Rewritten, text: str) -> Step:
    name, *objects = text.strip("()").split()
    return task.original(name, objects)


def enumerates(task: tuple[Domain, Problem], ask: Ask, negation: bool, most: int) -> None:
    """Compare what an optimal planner finds, asked again and again, with brute force."""
    layers = plain_plans(*task)
    assume(layers is not None and any(layers[1:]))
    assert layers is not None
    rewritten = portable(*task, negation, negation)
    found: list[Plan] = []
    exhausted = False
    while len(found) < most:
        left = forbid(rewritten, found)
        plan = None if left is None else ask(left)
        if plan is None:
            exhausted = True
            break
        found.append(plan)
    assert len(set(found)) == len(found)
    lengths = [len(plan) for plan in found]
    assert lengths == sorted(lengths)
    for length, layer in enumerate(layers):
        same = {plan for plan in found if len(plan) == length}
        if exhausted or (lengths and length < lengths[-1]):
            assert same == layer
        else:
            assert same <= layer


@settings(max_examples=25)
@given(rich_tasks(), st.booleans())
def test_astar_asked_again_enumerates_all_plans(task: tuple[Domain, Problem], negation: bool) -> None:
    enumerates(task, ask_astar, negation, 12)


@settings(max_examples=15)
@given(rich_tasks())
def test_pyperplan_asked_again_enumerates_all_plans(
    tmp_path_factory: pytest.TempPathFactory, task: tuple[Domain, Problem]
) -> None:
    folder = tmp_path_factory.mktemp("task")
    enumerates(task, lambda left: ask_pyperplan(left, folder), False, 10)


@settings(max_examples=15)
@given(rich_tasks(), st.booleans())
def test_kairos_asked_again_enumerates_all_plans(task: tuple[Domain, Problem], negation: bool) -> None:
    enumerates(task, ask_kairos, negation, 10)


# ------------------------------------------------------------------------------------- by hand


def test_reorderings_of_a_forbidden_plan_remain() -> None:
    first = steps(
        "Pick block0 robby, Place block0 target0 robby, Pick block1 robby, Place block1 target1 robby"
    )
    left = forbid(PLACE_TWO, [first])
    assert left is not None
    assert ask_astar(left) == first[2:] + first[:2]


def test_nothing_is_left_where_the_empty_plan_is_forbidden() -> None:
    done = portable(COVER, cover_problem(0), False, False)
    assert forbid(done, [()]) is None
    assert forbid(done, []) is done


@pytest.mark.parametrize(
    ("plan", "text"),
    [
        ("Place block0 target0 robby", "step 1 (Place block0 target0 robby) is not applicable"),
        ("Pick block0 robby", "a sequence of 1 step(s) does not reach the goal"),
        (
            "Pick block0 robby, Place block0 target0 robby, Pick block1 robby, Place block1 target1 robby, "
            "Pick block1 robby",
            "step 5 (Pick block1 robby) comes after the goal was reached",
        ),
    ],
)
def test_a_sequence_that_is_no_plan_is_refused(plan: str, text: str) -> None:
    with pytest.raises(ValueError) as error:  # noqa: PT011 - the text is compared below
        forbid(PLACE_TWO, [steps(plan)])
    assert str(error.value) == text


def test_nodes_are_no_objects_of_operators_and_share_no_name() -> None:
    x = Variable("?here", OBJECT)
    seen = Predicate("at-node", (OBJECT,))
    look = Operator("look", (x,), frozenset(), frozenset({seen.lifted(x)}), frozenset())
    node, outside = Object("node0", OBJECT), Object("outside", OBJECT)
    task = Problem("p", (node, outside), frozenset(), frozenset({seen(node), seen(outside)}))
    rewritten = portable(Domain("d", (), (seen,), (look,)), task, False, False)
    left = forbid(rewritten, [(("look", ("node0",)), ("look", ("outside",)))])
    assert left is not None
    plans = rewritten_plans(left)
    assert plans is not None
    assert plans[2] == {(("look", ("outside",)), ("look", ("node0",)))}


def test_other_readers_take_what_is_written(tmp_path: Path, data: Path) -> None:
    kairos = pytest.importorskip("kairos")
    io = pytest.importorskip("unified_planning.io")
    parser = pytest.importorskip("pyperplan.pddl.parser")
    domain = read_domain(data / "pddl-bench" / "coffee-domain.pddl")
    problem = read_problem(data / "pddl-bench" / "coffee-2.pddl", domain)
    rewritten = portable(domain, problem, False, False)
    plan = ask_astar(rewritten)
    assert plan is not None
    left = forbid(rewritten, [plan])
    assert left is not None
    texts = write_domain(left.domain), write_problem(left.problem, left.domain)
    assert kairos.check_problem(texts[1], texts[0]).diagnostics == []
    assert kairos.check_domain(texts[0]).diagnostics == []
    io.PDDLReader().parse_problem_string(*texts)
    for name, text in zip(("domain", "problem"), texts, strict=True):
        (tmp_path / name).write_text(text)
    reader = parser.Parser(str(tmp_path / "domain"), str(tmp_path / "problem"))
    reader.parse_problem(reader.parse_domain())
