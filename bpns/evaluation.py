"""Models on evaluation tasks: planned, refined and executed, each counted by itself."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import nullcontext
from dataclasses import asdict, dataclass, replace
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bpns import __version__
from bpns.learning.experiments.evaluation import Result, Summary, summarize
from bpns.learning.experiments.evaluation import evaluate as evaluate_solver
from bpns.learning.experiments.results import Run, Store, add_result, open_results, read_results
from bpns.learning.experiments.summary_text import cells, new_table, table_text
from bpns.learning.models.solver import Solver
from bpns.model import Model
from bpns.symbolic.bilevel.settings import SearchSettings
from bpns.symbolic.errors import InputError, MissingPackage
from bpns.symbolic.planners.protocol import Planner

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """The results of an evaluation, one for each model, seed and task. Printed, it is a table.

    ``results`` has for each task the number of its model in ``models`` and what came of it; ``found`` of them
    were in the file already.
    """

    models: tuple[str, ...]
    results: tuple[tuple[int, Result], ...]
    planner: str  # its whole name
    found: int = 0

    @property
    def runs(self) -> dict[tuple[int, int], list[Result]]:
        """Results by run: model (its number) and seed."""
        runs: dict[tuple[int, int], list[Result]] = {}
        for index, result in self.results:
            runs.setdefault((index, result.seed), []).append(result)
        return runs

    @property
    def summary(self) -> Summary:
        """Means over runs and population standard deviations; shares are in percent, times in seconds."""
        return summarize(self.runs)

    @property
    def rows(self) -> list[dict[str, Any]]:
        """One row of plain values for each task. Times are seconds of wall clock."""
        return [{"model": self.models[index], **asdict(result)} for index, result in self.results]

    def to_pandas(self) -> "DataFrame":
        """Return the rows as a data frame. Raises MissingPackage where pandas is not installed."""
        try:
            from pandas import DataFrame
        except ModuleNotFoundError as error:
            raise MissingPackage("to_pandas needs pandas: pip install pandas") from error
        return DataFrame(self.rows)

    def __iter__(self) -> Iterator[Result]:
        return (result for _, result in self.results)

    def __len__(self) -> int:
        return len(self.results)

    def __repr__(self) -> str:
        return f"<{len(self)} tasks, {sum(result.executed for result in self)} solved>"

    def __str__(self) -> str:
        """Return a row for each model and seed, their mean, and why tasks were not solved."""
        table = new_table(("model",), ("seed", "tasks"))
        runs = self.runs
        for (index, seed), rows in runs.items():
            numbers = cells(summarize({0: rows}), deviations=False)
            table.add_row(self.models[index], str(seed), str(len(rows)), *numbers)
        if len(runs) > 1:
            table.add_section()
            table.add_row("mean (std)", "", str(len(self)), *cells(summarize(runs), deviations=True))
        return "\n".join([table_text(table), *self._remarks()])

    def _remarks(self) -> Iterator[str]:
        for remark, times in Counter(remark for result in self for remark in result.remarks).most_common():
            yield f"the planner in {times} tasks: {remark}"
        for index, result in self.results:
            if not result.executed:
                where = f"{self.models[index]}, seed {result.seed}, task {result.task}"
                yield f"not solved: {where}: {result.fault}"
                for end, times in result.dead_ends[:3]:
                    yield f"  {times} x plan {end.plan}, step {end.step} {end.operator}: {end.reason}"


def evaluate(
    models: Model | Sequence[Model],
    tasks: int = 50,
    seeds: Iterable[int] | None = None,
    planner: str | Planner = "astar",
    timeout: float | None = None,
    search: SearchSettings = SearchSettings(),
    out: Path | str | None = None,
    workers: int = 1,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Evaluation:
    """Solve the first ``tasks`` evaluation tasks of every seed with each model, and carry the plans out.

    Without seeds each model is on its own. ``timeout`` is in seconds per task. With ``out``, an SQLite file,
    each result is added when it is there, and what the file has is not run again. Times aside, ``workers``
    (processes) change nothing; for times that you report, use one. Raises InputError for models of several
    environments. Source: spec, algorithm.md section 10.

    >>> import bpns
    >>> model = bpns.oracle(bpns.load_environment("cover"))
    >>> bpns.evaluate(model, tasks=5, seeds=range(2))
    <10 tasks, 10 solved>
    """
    chosen = [models] if isinstance(models, Model) else list(models)
    if len({model.world.name for model in chosen}) != 1:
        raise InputError("give models of one environment: evaluate others one by one")
    asked = None if seeds is None else list(seeds)
    jobs = [
        (*_job(model, planner, timeout, search), [model.seed] if asked is None else asked) for model in chosen
    ]
    results: list[tuple[int, Result]] = []
    found = 0
    total = tasks * sum(len(of_model) for _, _, of_model in jobs)
    with open_results(Path(out), True) if out else nullcontext() as store:
        for index, (solver, run, of_model) in enumerate(jobs):
            known = {} if store is None else read_results(store, run)
            known = {(s, t): result for (s, t), result in known.items() if s in of_model and t < tasks}
            note = _note(store, run, progress, len(results) + len(known), total)
            results += [
                (index, one) for one in evaluate_solver(solver, of_model, tasks, workers, note, known)
            ]
            found += len(known)
    return Evaluation(_labels(chosen), tuple(results), jobs[0][0].planner.name, found)


def _job(
    model: Model, planner: str | Planner, timeout: float | None, search: SearchSettings
) -> tuple[Solver, Run]:
    """Return what solves a model's tasks, and its description for the file: all that decides the results."""
    solver = model.solver(planner, timeout, search)
    budget = solver.budget
    exhaustive = search.name == "exhaustive"  # the adaptive search has no limits unless it is given some
    run = Run(
        environment=model.world.asked,
        origin=model.origin,
        preset=search.preset,
        strategy=search.name,
        planner=solver.planner.name,
        plans=budget.abstract_plans if exhaustive else search.plans,
        samples_per_step=budget.samples_per_step if exhaustive else search.samples,
        samples_per_plan=budget.samples_per_plan if exhaustive else None,
        sample_limit=budget.samples,
        node_limit=budget.nodes,
        timeout=timeout,
        version=__version__,
    )
    if model.graph is None:
        return solver, run
    acts = replace(run, preset="default", strategy=None, planner=None, plans=None)
    return solver, replace(
        acts, samples_per_step=None, samples_per_plan=None, sample_limit=None, node_limit=None
    )


def _labels(models: Sequence[Model]) -> tuple[str, ...]:
    """Return what to call models: their folders' names, or where these are alike the whole paths."""
    labels = tuple(model.label for model in models)
    if len(set(labels)) == len(labels):
        return labels
    return tuple(str(model.folder or model.label) for model in models)


def _note(
    store: Store | None, run: Run, progress: Callable[[int, int], None], before: int, total: int
) -> Callable[[Result], None]:
    """Return what is to be done with each new result."""
    numbers = count(before + 1)

    def note(result: Result) -> None:
        if store is not None:
            add_result(store, run, result)
        progress(next(numbers), total)

    return note
