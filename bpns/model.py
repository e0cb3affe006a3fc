"""Models: skills that plan together, saved, loaded, renamed and extended."""

import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from bpns.learning.graphs.reactive import GraphModel
from bpns.learning.graphs.saved import graph_entry
from bpns.learning.models.files import SkillEntry, check_model_output, model_folders, read_model_file
from bpns.learning.models.load import read_model
from bpns.learning.models.origin import ORACLE, Origin, read_origin
from bpns.learning.models.own import load_skill
from bpns.learning.models.save import entry_of_own, write_model
from bpns.learning.models.solver import Outcome, Solver, attempt
from bpns.symbolic import planners
from bpns.symbolic.bilevel.settings import SearchSettings
from bpns.symbolic.errors import InputError
from bpns.symbolic.files import read_json
from bpns.symbolic.operators import Domain, Operator
from bpns.symbolic.pddl.write import model_names
from bpns.symbolic.planners.protocol import Planner
from bpns.symbolic.skills.environment import Environment, domain_of
from bpns.symbolic.skills.skill import Skill
from bpns.symbolic.state import Task
from bpns.world import World, load_environment


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """Skills of one world, each an operator with policy and sampler. ``learn`` and ``load_model`` make one.

    A model is never changed: what changes it gives a new one. ``entries`` say where each skill is from, and
    ``run`` how it was learned (settings, seconds, versions).

    >>> import bpns
    >>> model = bpns.oracle(bpns.load_environment("cover"))
    >>> print(model.operators["Pick"])
    Pick:
      Parameters: [?block:block, ?gripper:gripper]
      Preconditions: [HandEmpty(), IsBlock(?block:block)]
      Add Effects: [Holding(?block:block, ?gripper:gripper)]
      Delete Effects: [HandEmpty()]
    """

    world: World
    label: str  # for tables
    approach: str  # "bpns", "oracle", ...
    seed: int
    skills: Mapping[str, Skill]  # by operator name
    entries: Mapping[str, SkillEntry] = field(default_factory=dict)  # of skills.json
    graph: GraphModel | None = None  # acts in place of a planner
    training: tuple[float, int] = (0.0, 0)  # of the graph network: best loss, epochs
    run: Mapping[str, Any] = field(default_factory=dict)  # run.json
    header: str = ""  # the first lines of domain.pddl
    folder: Path | None = None  # where it was loaded from

    @property
    def operators(self) -> dict[str, Operator]:
        """The operators by name. Printed, one has the paper's notation; a notebook shows a table."""
        return {name: skill.operator for name, skill in self.skills.items()}

    @property
    def domain(self) -> Domain:
        """Types, predicates and operators, as domain.pddl has them."""
        return domain_of(self.world.environment, self.operators.values())

    def plan(
        self,
        task: Task,
        planner: str | Planner = "astar",
        timeout: float | None = None,
        search: SearchSettings = SearchSettings(),
        seed: int | None = None,
    ) -> Outcome:
        """Plan for a task, refine a plan in the simulator and carry it out.

        ``planner`` is a name as in ``bpns planners``, with options after colons, or an object that enumerates
        abstract plans. ``timeout`` is in seconds; without one the budget counts nodes and samples. The seed
        is of the planner and the samplers (the model's, if none is given). A task without a plan is no error:
        the outcome says why. Raises InputError for unknown planners, MissingPackage where one is not
        installed. Source: spec, algorithm.md sections 7 to 9.

        >>> import bpns
        >>> world = bpns.load_environment("cover")
        >>> outcome = bpns.oracle(world).plan(world.task("test", 3), timeout=60)
        >>> print(outcome.plan)
        1. Pick(block0, robby)  (2 actions)
        2. Place(block0, robby, target0)  (3 actions)
        >>> outcome.executed, outcome.why, len(outcome.states), len(outcome.actions)
        (True, '', 6, 5)
        """
        deadline = None if timeout is None else time.monotonic() + timeout
        return attempt(
            self.solver(planner, timeout, search), task, self.seed if seed is None else seed, deadline
        )

    def solver(
        self,
        planner: str | Planner = "astar",
        timeout: float | None = None,
        search: SearchSettings = SearchSettings(),
    ) -> Solver:
        """Return what solves tasks with this model. Internal: ``plan`` and ``evaluate`` use it."""
        chosen = planners.load(planner) if isinstance(planner, str) else planner
        strategy, budget = search.within(self.world.environment)
        return Solver(self.world.environment, self.skills, chosen, budget, timeout, strategy, self.graph)

    @property
    def origin(self) -> Origin:
        """Where it is from, as files of results say it; of a model that was not saved, too."""
        if self.approach == ORACLE.approach:
            return ORACLE
        if self.folder is not None:
            return read_origin(self.folder)
        with TemporaryDirectory() as temporary:
            self.save(Path(temporary) / "model")
            return read_origin(Path(temporary) / "model")

    def save(self, folder: Path | str, overwrite: bool = False) -> None:
        """Write the model as a folder: domain.pddl (to be read and edited), weights, and how it was learned.

        In one piece: a fault leaves what was there. Raises InputError where there is something already, or
        where a skill is Python code that no module offers (see ``with_skill``).

        >>> import bpns
        >>> world = bpns.load_environment("cover")
        >>> model = bpns.learn(world, bpns.collect(world, count=20))
        >>> model.save("model")
        >>> bpns.load_model("model").operators == model.operators
        True
        """
        for name in self.skills:
            if name not in self.entries:
                raise InputError(
                    f"cannot save skill '{name}': its policy is Python code: "
                    "add it as 'module:attribute' with Model.with_skill"
                )
        check_model_output(Path(folder), overwrite)
        write_model(
            Path(folder),
            self.world.environment,
            self.world.asked,
            self.seed,
            [(skill, self.entries[name]) for name, skill in self.skills.items()],
            self.run,
            self.header,
            self.approach,
            None if self.graph is None else (self.graph, graph_entry(self.graph, self.training)),
            self.world.folder,
        )

    def renamed(self, names: Mapping[str, str]) -> "Model":
        """Return the model with other names of operators, everywhere at once: old name -> new name.

        Raises InputError for names that there are not, that are taken, or that PDDL cannot hold.

        >>> import bpns
        >>> model = bpns.oracle(bpns.load_environment("cover"))
        >>> list(model.renamed({"Pick": "Grasp"}).operators)
        ['Grasp', 'Place']
        """
        for name in names:
            self._check_has(name)

        def new(name: str) -> str:
            return names.get(name, name)

        skills: dict[str, Skill] = {}
        for name, skill in self.skills.items():
            if new(name) in skills:
                raise InputError(f"two operators would be called '{new(name)}'")
            skills[new(name)] = replace(skill, operator=replace(skill.operator, name=new(name)))
        model_names(domain_of(self.world.environment, (skill.operator for skill in skills.values())))
        graph = self.graph and replace(self.graph, skills=tuple(map(new, self.graph.skills)))
        entries = {new(name): entry for name, entry in self.entries.items()}
        return replace(self, skills=skills, entries=entries, graph=graph, folder=None)

    def with_skill(self, skill: "Skill | str") -> "Model":
        """Return the model with one more skill: an operator with a policy and a sampler of one's own.

        As "module:attribute" it can be saved, and is loaded from there with the model; its operator is then
        in domain.pddl, to be edited like the others. A skill of the same name is replaced. Raises InputError
        where there is no such skill, or where its operator does not fit the world.

        >>> import bpns
        >>> world = bpns.load_environment("cover")
        >>> pick = bpns.oracle(world).skills["Pick"]
        >>> place = bpns.oracle(world).without("Pick")
        >>> list(place.with_skill(pick).operators)
        ['Place', 'Pick']
        """
        name = skill if isinstance(skill, str) else ""
        folders = [self.world.folder] if self.world.folder else []
        own = load_skill(skill, self.world.environment, folders) if isinstance(skill, str) else skill
        skills = {**self.skills, own.operator.name: own}
        model_names(domain_of(self.world.environment, (one.operator for one in skills.values())))
        entries = {n: e for n, e in self.entries.items() if n != own.operator.name}
        if name:
            entries[own.operator.name] = entry_of_own(own, name)
        return replace(self, skills=skills, entries=entries, folder=None)

    def without(self, operator: str) -> "Model":
        """Return the model without one of its skills. Raises InputError where there is none of that name."""
        self._check_has(operator)
        if self.graph is not None and operator in self.graph.skills:
            raise InputError(f"the graph network chooses among its skills: '{operator}' cannot be taken away")
        return replace(
            self,
            skills={n: s for n, s in self.skills.items() if n != operator},
            entries={n: e for n, e in self.entries.items() if n != operator},
            folder=None,
        )

    def _check_has(self, operator: str) -> None:
        if operator not in self.skills:
            raise InputError(f"no operator '{operator}' in {self.label} (have: {', '.join(self.skills)})")

    def __repr__(self) -> str:
        return f"<model {self.label}: {self.approach} in {self.world.asked}; {', '.join(self.skills)}>"


def load_model(folder: Path | str, environment: "str | Environment | World | None" = None) -> Model:
    """Return the model in a folder that ``save`` or ``bpns learn`` wrote, with domain.pddl as it is now.

    The model knows its environment; another ``environment`` is a variant of it, such as
    "stick_button:test_buttons=10", or the object itself where no module offers it. Raises InputError where
    the folder is no model, is incomplete, or does not fit the environment.

    >>> import bpns
    >>> world = bpns.load_environment("cover")
    >>> bpns.learn(world, bpns.collect(world, count=20)).save("cover")
    >>> bpns.load_model("cover")
    <model cover: bpns in cover; Op0, Op1>
    """
    folder = Path(folder)
    file = read_model_file(folder)
    world = load_environment(environment or file.load, model_folders(folder, file))
    saved = read_model(folder, world.environment)
    label = folder.name or str(folder)
    return Model(
        world,
        f"{label} in {world.asked}" if environment else label,
        saved.approach,
        saved.seed,
        saved.skills,
        saved.entries,
        saved.graph,
        file.graph.training if file.graph else (0.0, 0),
        read_json(folder / "run.json") if (folder / "run.json").exists() else {},
        saved.header,
        folder,
    )


def oracle(world: World) -> Model:
    """Return the environment's own skills as a model: what demonstrates, and what learning is measured with.

    >>> import bpns
    >>> bpns.oracle(bpns.load_environment("cover"))
    <model oracle:cover: oracle in cover; Pick, Place>
    """
    skills = {skill.operator.name: skill for skill in world.environment.oracle_skills}
    return Model(world, f"oracle:{world.asked}", ORACLE.approach, 0, skills)
