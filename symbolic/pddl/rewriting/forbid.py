"""A task whose plans are those of another one except some, for planners that give one plan a call.

The forbidden plans are merged into a trie. Where a plan has followed it so far, the abstract state is known,
and with it every move: a step that can be next, and the node that it leads to, or the one that stands for all
that lies outside of the trie. Last steps of forbidden plans are no moves, and that is all: no negative
conditions are needed, and there are only as many moves as applicable steps along the forbidden plans. Each
move is one step, so that costs stay.

The moves are operators without parameters. As rows of a table for each operator they would be fewer lines,
but planners that ground by trying all objects do not cope with two more parameters.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from bpns.symbolic.grounding.ground import Unreachable, ground
from bpns.symbolic.grounding.masks import CompiledProblem, applicable_operators, compile_problem
from bpns.symbolic.operators import Domain, GroundOperator, Operator
from bpns.symbolic.pddl.rewriting.legal import Names
from bpns.symbolic.pddl.rewriting.portable import Origin, Rewritten
from bpns.symbolic.structs import OBJECT, LiftedAtom, Object, Predicate, Type, Variable

Step = tuple[str, tuple[str, ...]]  # operator and objects, as in the original task
_Move = tuple[int, GroundOperator, int | None]  # a node, a step, the node after it; None: outside of the trie


def forbid(task: Rewritten, plans: Sequence[Sequence[Step]]) -> Rewritten | None:
    """Return a task with the same plans except exactly these sequences; None where that leaves none.

    Plans are given as steps of the original task, and each must end at its first goal state. None means that
    the empty plan is among them: the goal holds at the start, so nothing else ends at its first goal state.
    Inside the trie, steps that change nothing are left out: plans that wait there are the forbidden plans.
    Raises ValueError for a sequence that is no plan.
    """
    if not plans:
        return task
    found = ground(task.domain, task.problem)
    if isinstance(found, Unreachable):
        raise ValueError(f"nothing to forbid: {found}")
    trie = _Trie(task, compile_problem(found))
    for plan in plans:
        trie.add(plan)
    if trie.nodes[0].last:
        return None
    return _Writer.of(task, len(trie.nodes)).written(trie.moves())


@dataclass(slots=True)
class _Node:
    state: int
    edges: dict[Step, int] = field(default_factory=dict)  # step -> number of the node after it
    last: bool = False  # a forbidden plan ends here


class _Trie:
    """The forbidden plans; node 0 is the start."""

    def __init__(self, task: Rewritten, compiled: CompiledProblem) -> None:
        self._compiled = compiled
        self._applicable = applicable_operators(compiled)
        self._steps = [
            task.original(o.ground.operator.name, [obj.name for obj in o.ground.objects])
            for o in compiled.operators
        ]
        self.nodes = [_Node(compiled.init)]

    def add(self, plan: Sequence[Step]) -> None:
        """Add a plan; raise ValueError where it is none."""
        here = self.nodes[0]
        for number, (name, arguments) in enumerate(plan, 1):
            step = (name, tuple(arguments))
            text = f"step {number} ({' '.join([name, *arguments])})"
            if self._compiled.is_goal(here.state):
                raise ValueError(f"{text} comes after the goal was reached")
            if step not in here.edges:
                here.edges[step] = len(self.nodes)
                self.nodes.append(_Node(self._after(here.state, step, text)))
            here = self.nodes[here.edges[step]]
        if not self._compiled.is_goal(here.state):
            raise ValueError(f"a sequence of {len(plan)} step(s) does not reach the goal")
        here.last = True

    def _after(self, state: int, step: Step, text: str) -> int:
        for number in self._applicable(state):
            if self._steps[number] == step:
                return self._compiled.operators[number].apply(state)
        raise ValueError(f"{text} is not applicable")

    def moves(self) -> Iterator[_Move]:
        """Yield what can be done inside of the trie."""
        for place, node in enumerate(self.nodes):
            for number in () if node.last else self._applicable(node.state):
                operator = self._compiled.operators[number]
                following = node.edges.get(self._steps[number])
                if following is not None:
                    if not self.nodes[following].last:
                        yield place, operator.ground, following
                elif operator.apply(node.state) != node.state:
                    yield place, operator.ground, None


@dataclass(frozen=True, slots=True)
class _Writer:
    """Adds nodes and moves to a task."""

    task: Rewritten
    names: Names
    nodes: tuple[Object, ...]
    outside: Object
    at: Predicate
    thing: Predicate  # tells the task's objects from nodes

    @classmethod
    def of(cls, task: Rewritten, size: int) -> "_Writer":
        """Name everything that is new."""
        domain, problem = task.domain, task.problem
        taken = [domain.name, problem.name, *(t.name for t in domain.types)]
        taken += [p.name for p in domain.predicates] + [o.name for o in domain.operators]
        names = Names(taken + [o.name for o in (*domain.constants, *problem.objects)])
        node = Type(names.fresh("node", "type")) if domain.types else OBJECT
        nodes = tuple(Object(names.fresh(f"node{number}", "object"), node) for number in range(size))
        outside = Object(names.fresh("outside", "object"), node)
        at = Predicate(names.fresh("at-node", "predicate"), (node,))
        return cls(
            task, names, nodes, outside, at, Predicate(names.fresh("is-thing", "predicate"), (OBJECT,))
        )

    def place(self, number: int | None) -> Object:
        return self.outside if number is None else self.nodes[number]

    def written(self, moves: Iterable[_Move]) -> Rewritten:
        """Write moves as operators without parameters; all objects become constants."""
        operators, origins = [], {}
        for here, step, there in moves:
            binding = dict(zip(step.operator.parameters, step.objects, strict=True))
            version = _bind(self.inside(step.operator, self.place(here), self.place(there)), binding)
            operators.append(version)
            objects = [o.name for o in step.objects]
            origins[version.name] = Origin(*self.task.original(step.operator.name, objects), 0)
        task = self.rewritten(operators, origins)
        constants = (*task.domain.constants, *task.problem.objects)
        return replace(
            task, domain=replace(task.domain, constants=constants), problem=replace(task.problem, objects=())
        )

    def inside(self, operator: Operator, here: Object, there: Object) -> Operator:
        """Return what an operator does inside of the trie; a node implies what the operator requires."""
        return Operator(
            self.names.fresh(f"{operator.name}-inside", "operator"),
            operator.parameters,
            frozenset({self.at.lifted(here)}),
            operator.add_effects | {self.at.lifted(there)},
            operator.delete_effects | {self.at.lifted(here)},
        )

    def outside_version(self, operator: Operator) -> Operator:
        """Return an operator for outside of the trie; what could be any object is kept from being a node."""
        bound = {t for a in operator.preconditions if a.predicate.name != "=" for t in a.terms}
        free = [v for v in operator.parameters if v.type == OBJECT and v not in bound]
        more = {self.at.lifted(self.outside), *(self.thing.lifted(v) for v in free)}
        return replace(operator, preconditions=operator.preconditions | more)

    def rewritten(self, operators: list[Operator], origins: dict[str, Origin]) -> Rewritten:
        """Return the task with the given versions for inside of the trie, at its first node."""
        domain, problem = self.task.domain, self.task.problem
        versions = [*map(self.outside_version, domain.operators), *operators]
        init = {self.at(self.nodes[0])}
        new = [self.at]
        if any(a.predicate == self.thing for o in versions for a in o.preconditions):
            init |= {self.thing(o) for o in (*domain.constants, *problem.objects)}
            new.append(self.thing)
        types = (*domain.types, *self.at.types) if domain.types else ()
        constants = (*domain.constants, self.outside)
        return Rewritten(
            Domain(domain.name, types, (*domain.predicates, *new), tuple(versions), constants),
            replace(problem, objects=(*problem.objects, *self.nodes), init=problem.init | init),
            {**self.task.operators, **origins},
            self.task.objects,
        )


def _bind(operator: Operator, binding: Mapping[Variable, Object]) -> Operator:
    """Replace an operator's parameters by objects."""

    def bound(atoms: frozenset[LiftedAtom]) -> frozenset[LiftedAtom]:
        return frozenset(LiftedAtom(a.predicate, a.ground(binding).objects) for a in atoms)

    add = bound(operator.add_effects)
    delete = bound(operator.delete_effects) - add
    return Operator(operator.name, (), bound(operator.preconditions), add, delete)
