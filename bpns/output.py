"""Models and tasks as PDDL for any planner, outcomes as pictures."""

from pathlib import Path

from bpns.envs import animation
from bpns.learning.models.solver import Outcome
from bpns.model import Model
from bpns.symbolic.errors import InputError
from bpns.symbolic.files import check_output, read_text, write_text
from bpns.symbolic.pddl.rewriting.portable import portable
from bpns.symbolic.pddl.write import write_domain, write_problem
from bpns.symbolic.skills import own_task
from bpns.symbolic.skills.environment import problem_of, sample_tasks
from bpns.symbolic.state import State
from bpns.symbolic.structs import sort_atoms
from bpns.world import World


def export(
    model: Model,
    folder: Path | str,
    problems: int = 10,
    seed: int | None = None,
    positive: bool = False,
    overwrite: bool = False,
) -> None:
    """Write domain.pddl and p01.pddl, p02.pddl, ...: the first evaluation tasks of a seed (the model's own).

    Every name is used once, over types, predicates, operators and objects, as some planners need it. With
    ``positive`` negative conditions are compiled away. Raises InputError where files exist and are not to be
    overwritten.

    >>> import bpns
    >>> bpns.export(bpns.oracle(bpns.load_environment("cover")), "cover-pddl", problems=2)
    """
    folder = Path(folder)
    world, domain = model.world, model.domain
    seed = model.seed if seed is None else seed
    source = f"{model.label}: environment {world.asked}"
    own_text = read_text(model.folder / "domain.pddl") if model.folder else write_domain(domain, source)
    texts = {"domain.pddl": own_text}
    digits = max(2, len(str(problems)))
    for index, task in enumerate(sample_tasks(world.environment, "test", problems, seed)):
        name = f"p{index + 1:0{digits}}"
        problem = problem_of(world.environment, task, name)
        task_of = portable(domain, problem, negation=not positive, equality=True)
        header = f"evaluation task {index} of seed {seed}, environment {world.asked}"
        texts[f"{name}.pddl"] = write_problem(task_of.problem, task_of.domain, header)
        text = write_domain(task_of.domain, source)
        if text != write_domain(domain, source):  # the model's own text has its comments
            if texts["domain.pddl"] not in (own_text, text):
                raise InputError("these problems need different domains: export them one by one")
            texts["domain.pddl"] = text
    if (folder / "skills.json").exists():
        raise InputError(
            f"{folder} is a model folder, and its domain.pddl is the model's own: give another --out"
        )
    for name in texts:
        check_output(folder / name, overwrite)
    for name, text in texts.items():
        write_text(folder / name, text)


def animate(path: Path | str, world: World, outcome: Outcome) -> None:
    """Write what was carried out as .gif, .webp or animated .png.

    Captions say the step, the atoms that change, and the goal. Raises InputError for other formats, and where
    nothing was carried out.

    >>> import bpns
    >>> world = bpns.load_environment("cover")
    >>> bpns.animate("plan.gif", world, bpns.oracle(world).plan(world.task()))
    """
    animation.animation_format(Path(path))
    if outcome.execution is None:
        raise InputError(f"no animation, as there is no plan: {path} is not written")
    goal = ", ".join(map(str, sort_atoms(outcome.task.goal)))
    names = [f"{number}. {step}" for number, step in enumerate(outcome.steps, 1)] or ["acting"]
    abstract_states = [world.abstract(state) for state in outcome.states]
    always = frozenset.intersection(*abstract_states)
    captions = []
    for atoms, owner in zip(abstract_states, [*outcome.execution.steps, None], strict=True):
        name = (outcome.why or "done") if owner is None else names[owner]
        shown = ", ".join(map(str, sort_atoms(atoms - always)))
        captions.append(f"{name}\n{shown}\ngoal: {goal}")
    animation.write_animation(Path(path), world.environment, outcome.states, captions, outcome.task.goal)


def write_state(path: Path | str, state: State, overwrite: bool = False) -> None:
    """Write a state as JSON, to be edited and given to ``World.own_task`` or ``bpns plan --init``.

    Raises InputError where the file exists and is not to be overwritten.

    >>> import bpns
    >>> world = bpns.load_environment("cover")
    >>> bpns.write_state("state.json", world.task().init)
    >>> world.own_task("Covers(block0, target1)", "state.json")
    <task: Covers(block0, target1); 9 objects>
    """
    check_output(Path(path), overwrite)
    own_task.write_state(Path(path), state)
