"""The graph of nodes that our search walks on, made as it goes: ``nodes`` says what they are."""

from collections.abc import Sequence
from heapq import heappop, heappush
from math import inf

from bpns.symbolic.grounding.heuristics import Heuristic, LmCut
from bpns.symbolic.grounding.masks import CompiledProblem, successor_function
from bpns.symbolic.planners.astar.branch_values import BranchValues
from bpns.symbolic.planners.astar.exact import measure
from bpns.symbolic.planners.astar.falling import relax_all, spread
from bpns.symbolic.planners.astar.nodes import Branch, EnoughError, Node, Path, State, StoppedError
from bpns.symbolic.planners.astar.space import Space, explore
from bpns.symbolic.planners.protocol import Limit, SearchRecord

CHEAP = 16  # states that are looked at before the heuristic is asked about more of them
_DEAD_END = 10_000  # states that are looked at to find out whether one of them leads to a goal


class Product:
    """The nodes made so far, with values that only rise while costs stay.

    A value above its ``base`` is never above the least of cost plus value among the children. So when a cost
    falls, it is enough to lower what depends on it, and values stay lower bounds.
    """

    def __init__(
        self,
        problem: CompiledProblem,
        heuristic: Heuristic,
        limit: Limit,
        record: SearchRecord,
        tracked: bool,
    ) -> None:
        self.problem = problem
        self.heuristic = heuristic
        self.landmarks = heuristic if isinstance(heuristic, LmCut) else None
        self.limit = limit
        self.record = record
        self.tracked = tracked  # whether costs may fall
        self.costs = [1.0] * len(problem.operators)
        self.users: list[list[tuple[State, int]]] = [[] for _ in problem.operators]
        self.successors = successor_function(problem)
        self.states: dict[int, State] = {}
        self.branches: list[Branch] = []
        self.touched: dict[Branch, None] = {}  # those that changed since values were measured
        self.space: Space | None = None
        self.branch_values = BranchValues(0)
        self.patience = inf  # until how many states are opened we go on without
        record.nodes_created += 1
        start = self.states[problem.init] = State(problem.init, problem.is_goal(problem.init), 0, None)
        self.root: Node = start
        self.evaluate(start)

    def check(self) -> None:
        """Raise StoppedError at a limit, EnoughError where patience ends."""
        if self.record.nodes_expanded > self.patience:
            raise EnoughError
        if self.limit.late:
            self.record.stopped_by = "time limit"
        elif self.record.nodes_created >= self.limit.nodes:
            self.record.stopped_by = "node limit"
        else:
            return
        raise StoppedError

    def evaluate(self, state: State) -> None:
        """Ask the heuristic about a state."""
        if state.unsure:
            state.unsure = False
            self.settle(state)
            found = self.heuristic(state.mask)
            state.base = max(state.base, found)
            state.value = max(state.value, found)

    def settle(self, state: State) -> None:
        """Fix the landmarks that a state has from where it was discovered."""
        if self.landmarks is not None and state.origin is not None:
            parent, operator = state.origin
            self.landmarks.inherit(state.mask, parent.mask, operator)
        state.origin = None

    def can_end(self, node: Node) -> bool:
        """Say whether a goal can be reached; if not, no value is high enough. Yes where it takes too long."""
        if node.alive or any(child.alive for child in self.open(node)):
            if isinstance(node, State):
                node.alive = True
            return True
        assert isinstance(node, State)
        came_from: dict[State, State | None] = {node: None}
        queue = [(node.value, 0, node)]
        while queue:
            self.check()
            _, _, now = heappop(queue)
            if now.alive or len(came_from) > _DEAD_END:
                for state in _chain(now, came_from) if now.alive else came_from:
                    state.alive = True
                return True
            if len(came_from) > CHEAP:
                self.evaluate(now)
            if now.value == inf:
                continue
            for child in self.open(now):
                assert isinstance(child, State)
                if child not in came_from and child.value < inf:
                    came_from[child] = now
                    heappush(queue, (child.value, -len(came_from), child))
        for state in came_from:
            state.value = state.base = inf
        return False

    def open(self, node: Node) -> list[Node]:
        """Return a node's children."""
        if node.children is None:
            self.check()
            self.record.nodes_expanded += 1
            node.children = self._expand(node) if isinstance(node, State) else self._branch_off(node)
        return node.children

    def _expand(self, state: State) -> list[Node]:
        """Apply what is applicable, but for what changes nothing."""
        self.settle(state)
        problem, states = self.problem, self.states
        found = [step for step in self.successors(state.mask) if step[1] != state.mask]
        state.operators = [number for number, _ in found]
        if self.landmarks is not None:
            total, covered = self.landmarks.known(state.mask)
            bounds: list[float] = [total - (number in covered) for number in state.operators]
        else:
            bounds = [max(0.0, state.base - 1)] * len(found)
        children: list[Node] = []
        for (number, mask), bound in zip(found, bounds, strict=True):
            child = states.get(mask)
            if child is None:
                goal = problem.is_goal(mask)
                if self.space is not None:
                    bound = float(self.space.distances[self.space.number(mask)])
                child = states[mask] = State(mask, goal, 0 if goal else bound, (state, number))
                child.unsure = child.unsure and self.space is None
                self.record.nodes_created += 1
            children.append(child)
        if self.tracked:
            for place, number in enumerate(state.operators):
                self.users[number].append((state, place))
                child = states[found[place][1]]
                if child.parents is None:
                    child.parents = []
                child.parents.append((state, place))
        return children

    def _branch_off(self, branch: Branch) -> list[Node]:
        """Copy the state's children; the one that the given plan goes on to becomes a branch."""
        children = list(self.open(branch.state))
        place, *rest = branch.rest
        branch.rest = ()
        following = children[place]
        assert isinstance(following, State)
        children[place] = self._branch(following, rest, branch, place)
        self.touched[branch] = None
        return children

    def _branch(self, state: State, rest: Sequence[int], above: Branch | None, place: int) -> Branch:
        branch = self._new_branch(state, rest, above, place)
        if self.tracked and rest:
            if state.branches is None:
                state.branches = []
            state.branches.append(branch)
        return branch

    def _new_branch(self, state: State, rest: Sequence[int], above: Branch | None, place: int) -> Branch:
        self.record.nodes_created += 1
        branch = Branch(state, rest, above, place, len(self.branches))
        self.branches.append(branch)
        self.touched[branch] = None
        return branch

    def follow(self, steps: Sequence[int]) -> Path:
        """Return the path of a plan."""
        path: Path = []
        node = self.root
        for number in steps:
            children = self.open(node)
            path.append((node, node.operators.index(number)))
            node = children[path[-1][1]]
        return path

    def give(self, path: Path) -> None:
        """Take a plan out of those that are left: a path from the root to a goal."""
        above: Branch | None = None
        came_by = -1
        for index, (node, place) in enumerate(path):
            if isinstance(node, State):
                self._hang(self._branch(node, [p for _, p in path[index:]], above, came_by))
                return
            node.given += 1
            above, came_by = node, place
        goal = self.root if above is None else self.open(above)[came_by]
        assert isinstance(goal, State)
        self._hang(self._branch(goal, (), above, came_by))

    def _hang(self, branch: Branch) -> None:
        if branch.above is None:
            self.root = branch
        else:
            self._put(branch)

    def _put(self, branch: Branch) -> None:
        """Let a branch stand where its state, or another branch of that state, stood."""
        assert branch.above is not None
        self.open(branch.above)[branch.place] = branch
        self.touched[branch.above] = None

    def change(self, costs: dict[int, float]) -> None:
        """Set costs of operators; lower the values that rest on those that fell, unless they are measured."""
        fallen = [number for number, cost in sorted(costs.items()) if cost < self.costs[number]]
        for number, cost in costs.items():
            self.costs[number] = cost
        if self.space is not None:
            return
        lowered: list[Node] = []
        for number in fallen:
            for state, place in self.users[number]:
                relax_all(state, place, None, self.costs, lowered)
        spread(lowered, self.costs)

    def explore(self) -> None:
        """From now on measure exact distances, where there are few enough states."""
        self.space = explore(self.problem)
        if self.space is not None:
            self.record.nodes_created += len(self.space.index)
            self.branch_values = BranchValues(len(self.space.index))
            self.touched = dict.fromkeys(self.branches)
            self.measure()

    def measure(self) -> None:
        """Set all values to what follows from exact distances at the present costs."""
        assert self.space is not None
        measure(self.space, self.branch_values, self.costs, self.states.values(), self.branches, self.touched)
        self.touched.clear()

    def penalize(self, steps: Sequence[int], extra: float) -> None:
        """Let all plans that begin with these steps, and go on, cost so much more."""
        branch = self._prefix(steps)
        if branch is not None:
            change = extra - branch.extra
            branch.extra = extra
            branch.value += change
            self.touched[branch] = None
            if change < 0 and self.space is None:
                spread([branch], self.costs)

    def close(self, steps: Sequence[int]) -> None:
        """Take all plans that begin with these steps out of those that are left."""
        above = self._prefix(steps[:-1])
        children = [] if above is None else self.open(above)
        if above is not None and steps[-1] in above.operators:
            place = above.operators.index(steps[-1])
            child = children[place]
            self._put(self._new_branch(child if isinstance(child, State) else child.state, (), above, place))

    def _prefix(self, steps: Sequence[int]) -> Branch | None:
        """Return the branch after these steps, a new one if need be; None where no plan begins so."""
        node: Node = self.root
        if isinstance(node, State):
            node = self.root = self._copy(node, None, 0)
        for number in steps:
            children = self.open(node)
            if number not in node.operators:
                return None
            place = node.operators.index(number)
            child = children[place]
            if isinstance(child, State):
                if child.goal:
                    return None
                assert isinstance(node, Branch)
                child = self._copy(child, node, place)
                self._put(child)
            node = child
        assert isinstance(node, Branch)
        return node

    def _copy(self, state: State, above: Branch | None, place: int) -> Branch:
        """Return a branch from which all plans are left."""
        children = list(self.open(state))
        branch = self._new_branch(state, (), above, place)
        branch.children = children
        branch.value, branch.base, branch.given = state.value, state.base, 0
        if state.branches is None:
            state.branches = []
        state.branches.append(branch)
        return branch


def _chain(state: State, came_from: dict[State, State | None]) -> list[State]:
    """Return a state and those before it."""
    found = [state]
    while (before := came_from[found[-1]]) is not None:
        found.append(before)
    return found
