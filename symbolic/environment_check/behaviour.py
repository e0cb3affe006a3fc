"""What an environment does, held against its protocol. Every check draws its own tasks: each stands alone."""

from collections.abc import Iterator
from contextlib import suppress
from itertools import islice, product
from multiprocessing.reduction import ForkingPickler

import numpy as np

from bpns.symbolic.environment_check.findings import Remark, Remarks, fault, kind_of, raised
from bpns.symbolic.environment_check.tasks import all_tasks, same, state_fault
from bpns.symbolic.skills.environment import Environment, EnvironmentFailure, sample_tasks
from bpns.symbolic.state import Array, State, Task
from bpns.symbolic.structs import GroundAtom

WALKS, STEPS = 3, 20  # random walks, and the actions of each
MOST_TUPLES = 500  # of arguments, for each predicate in each state


def transition(environment: Environment, state: State, action: Array, where: str) -> Remark | State | None:
    """Simulate a step twice; return the next state, None for an environment failure, or a fault."""
    before, sent = dict(state.features), action.copy()
    outcomes: list[State | None] = []
    for _ in range(2):
        after: State | None = None
        with suppress(EnvironmentFailure):
            after = environment.simulate(state, action)
            if wrong := state_fault(after, environment.types):
                return fault(f"{where}: after simulate, {wrong}")
            if after.objects != state.objects:
                odd = ", ".join(sorted({o.name for o in after.objects} ^ {o.name for o in state.objects}))
                return fault(f"{where}: simulate adds or removes objects ({odd}): a task keeps its own")
        if state.features != before:
            return fault(f"{where}: simulate changes the state it was given: use state.changed")
        if not np.array_equal(action, sent):
            return fault(f"{where}: simulate changes the action it was given: copy it first")
        outcomes.append(after)
    one, two = outcomes
    if (one is None) != (two is None) or (one and two and one.features != two.features):
        return fault(f"{where}: simulate gave two results for the same state and action: it must repeat")
    return one


def _finite_box(environment: Environment) -> tuple[Array, Array]:
    """Return a box to draw random actions from: infinite sides are cut."""
    low = np.where(np.isfinite(environment.action_low), environment.action_low, -1)
    low = np.where(np.isfinite(environment.action_high), np.minimum(low, environment.action_high), low)
    high = np.where(np.isfinite(environment.action_high), environment.action_high, np.maximum(low + 1, 1))
    return low, high


def _walk(environment: Environment, task: Task, seed: int) -> Iterator[tuple[State, Array]]:
    """Yield the states that random actions lead to, each with the next action."""
    rng = np.random.default_rng(seed)
    low, high = _finite_box(environment)
    state = task.init
    for _ in range(STEPS):
        action = rng.uniform(low, high).astype(np.float32)
        action = np.clip(action, environment.action_low, environment.action_high)
        yield state, action
        try:
            state = environment.simulate(state, action)
        except EnvironmentFailure:
            state = task.init


def simulate(environment: Environment, count: int, seed: int) -> Remarks:
    """Take random actions from a few tasks."""
    steps = failures = 0
    for number, task in enumerate(sample_tasks(environment, "train", min(count, WALKS), seed)):
        for step, (state, action) in enumerate(_walk(environment, task, seed), 1):
            after = transition(environment, state, action, f"train task {number}, random action {step}")
            if isinstance(after, Remark):
                yield after
                return ""
            steps += 1
            failures += after is None
    return f"{steps} random actions, {failures} environment failures"


def refusals(environment: Environment, count: int, seed: int) -> Remarks:
    """Ask whether simulate refuses what is no action; a warning, as nothing here sends such."""
    state = sample_tasks(environment, "train", 1, seed)[0].init
    low, high = _finite_box(environment)
    middle = ((low + high) / 2).astype(np.float32)
    wrong = {"of the wrong shape": np.append(middle, np.float32(0))}
    for text, bound, step in (("below", environment.action_low, -1), ("above", environment.action_high, 1)):
        for place in np.flatnonzero(np.isfinite(bound))[:1]:
            outside = middle.copy()
            outside[place] = bound[place] + np.float32(step)
            wrong[f"{text} the box"] = outside
    wrong["NaN"] = np.full_like(middle, np.nan)
    taken = []
    for text, action in wrong.items():
        try:
            environment.simulate(state, action)
        except EnvironmentFailure:
            taken.append(text)
        except Exception:
            continue
        else:
            taken.append(text)
    if taken:
        yield Remark("warning", f"simulate takes actions {', '.join(taken)}: raise ValueError")
    return "simulate refuses what is no action"


def classifiers(environment: Environment, count: int, seed: int) -> Remarks:
    """Ask every classifier, twice, in initial states and along random actions."""
    asked = 0
    for where, state in _some_states(environment, count, seed):
        wrong = classifier_fault(environment, state, where)
        if wrong is not None:
            yield wrong
            return ""
        asked += 1
    return f"{len(environment.classifiers)} asked in {asked} states"


def _some_states(environment: Environment, count: int, seed: int) -> Iterator[tuple[str, State]]:
    for where, task in all_tasks(environment, count, seed):
        yield where, task.init
    for number, task in enumerate(sample_tasks(environment, "train", min(count, WALKS), seed)):
        try:
            walk = list(_walk(environment, task, seed))
        except Exception:
            return  # simulate has its own check, which names this fault
        for step, (state, _) in islice(enumerate(walk), 4, None, 5):
            if not state_fault(state, environment.types):
                yield f"train task {number} after {step} random actions", state


def classifier_fault(environment: Environment, state: State, where: str) -> Remark | None:
    """Return the first fault of any classifier in a state."""
    for predicate, classifier in environment.classifiers.items():
        places = [[o for o in state.objects if o.type.is_a(t)] for t in predicate.types]
        for objects in islice(product(*places), MOST_TUPLES):
            atom = f"{where}: {GroundAtom(predicate, objects)}"
            before = dict(state.features)
            try:
                values = [classifier(state, objects) for _ in range(2)]
            except Exception as error:
                return fault(f"{atom}: {raised(error, environment)}")
            if any(type(value) is not bool for value in values):
                return fault(f"{atom} is a {kind_of(values[0])}: turn it into a bool")
            if values[0] != values[1]:
                return fault(f"{atom} is once true and once false in the same state: it must repeat")
            if state.features != before:
                return fault(f"{atom}: the classifier changes the state: it must only look")
    return None


def drawing(environment: Environment, count: int, seed: int) -> Remarks:
    """Draw an initial state of each split, without and with a caption and a goal."""
    from PIL.Image import Image  # planning needs no pictures

    for where, task in all_tasks(environment, 1, seed):
        before = dict(task.init.features)
        for more in ((), ("two lines\nof caption", task.goal)):
            picture = environment.draw(task.init, *more)
            if not isinstance(picture, Image):
                yield fault(f"{where}: draw gave a {kind_of(picture)}: return a Pillow image")
                return ""
        if task.init.features != before:
            yield fault(f"{where}: draw changes the state: it must only look")
            return ""
    return f"{picture.width} x {picture.height} pixels"


def workers(environment: Environment, count: int, seed: int) -> Remarks:
    """Send the environment through what worker processes use, and draw a task with what arrives."""
    try:
        again = ForkingPickler.loads(ForkingPickler.dumps(environment))
    except Exception as error:
        yield fault(
            f"cannot be sent to worker processes (--workers): {raised(error, environment)}: "
            "use functions and classes of a module instead of lambdas and inner ones"
        )
        return ""
    here, there = (sample_tasks(e, "test", 1, seed)[0] for e in (environment, again))
    if not same(here, there):
        yield fault("draws other tasks in worker processes: keep everything it needs in its attributes")
    return "it can be sent to worker processes"
