"""The paper's tables: one row for each approach with its settings. Source: spec, baselines.md."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import groupby
from typing import Any, NamedTuple

from bpns.learning import approaches
from bpns.learning.experiments.evaluation import Result, Summary, summarize
from bpns.learning.experiments.results import Run

ORDER = ("bpns", "no_subgoal", "gnn_meta", "gnn_meta_no_subgoal", "gnn_bc", "pass_through", "oracle")
EVERYWHERE = ("strategy", "planner")  # said where any two rows of a table differ
AMONG_NAMESAKES = (
    "learning_preset",
    "min_share",
    "plans",
    "samples_per_step",
    "samples_per_plan",
    "sample_limit",
    "node_limit",
    "timeout",
)  # said where rows of one title differ, whatever their numbers of demonstrations: so a line has one name


class RunName(NamedTuple):
    """One model on the tasks of one seed."""

    seed: int  # of the evaluation
    learning_seed: int | None
    model: str


@dataclass(frozen=True, slots=True)
class Row:
    """One approach with its settings in one environment."""

    run: Run  # what all of its runs share: without model, seeds, version
    title: str  # as in the paper, with what is special
    differences: str  # other settings in which it differs from rows beside it
    runs: Mapping[RunName, Sequence[Result]]
    summary: Summary

    @property
    def tasks(self) -> str:
        """How many tasks a run has; two numbers where runs differ."""
        counts = {len(results) for results in self.runs.values()}
        return str(min(counts)) if len(counts) == 1 else f"{min(counts)} to {max(counts)}"

    @property
    def label(self) -> str:
        """Title and differences."""
        return f"{self.title}, {self.differences}" if self.differences else self.title


def tables(results: Mapping[Run, Sequence[Result]]) -> dict[str, list[Row]]:
    """Return a table for each environment, sorted."""
    grouped: dict[str, dict[Run, dict[RunName, list[Result]]]] = {}
    for run, found in results.items():
        runs = grouped.setdefault(run.environment, {}).setdefault(_shared(run), {})
        for result in found:
            name = RunName(result.seed, run.origin.learning_seed, run.origin.model)
            runs.setdefault(name, []).append(result)
    return {
        environment: [_row(shared, group) for shared in sorted(group, key=_place)]
        for environment, group in sorted(grouped.items())
    }


def _shared(run: Run) -> Run:
    origin = replace(run.origin, model="", learning_seed=None, cpu_seconds=None)
    return replace(run, origin=origin, version="")


def _row(run: Run, group: Mapping[Run, dict[RunName, list[Result]]]) -> Row:
    def place(name: RunName) -> tuple[int, int, str]:
        return name.seed, name.learning_seed or 0, name.model

    runs = {name: group[run][name] for name in sorted(group[run], key=place)}
    return Row(run, title(run), _differences(run, list(group)), runs, summarize(runs))


def _place(run: Run) -> tuple[Any, ...]:
    approach = run.origin.approach
    number = ORDER.index(approach) if approach in ORDER else len(ORDER)
    return (number, len(_specials(run)), title(run), run.origin.demonstrations or 0, repr(run))


def _specials(run: Run) -> list[str]:
    """Name what sets a run apart from the plain approach, the paper's ablations first."""
    origin = run.origin
    found = []
    if origin.approach in ("bpns", "oracle"):  # the others have no choice of how often to sample or plan
        found += ["Samples=1"] if run.samples_per_step == 1 else []
        found += ["Abstract Plans=1"] if run.plans == 1 else []
        found += ["No filter"] if origin.min_share == 0 else []
    paper = origin.learning_preset == "paper", run.preset == "paper"
    if paper == (True, True) or (paper[1] and origin.approach == "oracle"):
        found.append("paper preset")
    elif any(paper):
        found.append("paper's learning" if paper[0] else "paper's search")
    return found


def base(run: Run) -> str:
    """Return the paper's name of an approach or ablation."""
    specials = _specials(run)
    if run.origin.approach == "bpns" and specials and not specials[0].startswith("paper"):
        return specials[0]
    name = run.origin.approach
    return approaches.load(name).title if name in approaches.names() else name


def title(run: Run) -> str:
    """Return the paper's name and what else is special."""
    first = base(run)
    return ", ".join([first, *(special for special in _specials(run) if special != first)])


def _differences(run: Run, group: Sequence[Run]) -> str:
    namesakes = [other for other in group if title(other) == title(run)]
    own = _settings(run)
    found = []
    for name in (*EVERYWHERE, *AMONG_NAMESAKES):
        values = {_settings(other)[name] for other in (group if name in EVERYWHERE else namesakes)}
        if name in EVERYWHERE and own[name] is not None and len(values - {None}) > 1:
            found.append(str(own[name]))
        elif name in AMONG_NAMESAKES and len(values) > 1:
            found.append(f"{name} {'none' if own[name] is None else own[name]}")
    return ", ".join(found)


def _settings(run: Run) -> dict[str, Any]:
    found = {**asdict(run.origin), **asdict(run)}
    if run.preset == "paper":
        found["strategy"] = None  # the title says it
    return found


def remarks(row: Row, table: Sequence[Row]) -> list[str]:
    """Return what a reader of a row's means should know: incomplete runs, several models of one seed.

    A run is incomplete beside others of its table with more tasks.
    """
    most = max(len(results) for other in table for results in other.runs.values())
    found = [
        f"incomplete: model {name.model}, seed {name.seed}: {len(results)} tasks of {most}"
        for name, results in row.runs.items()
        if len(results) < most
    ]
    models = sorted({(name.learning_seed, name.model) for name in row.runs if name.learning_seed is not None})
    for seed, group in groupby(models, key=lambda pair: pair[0]):
        several = [model for _, model in group]
        if len(several) > 1:
            found.append(f"{len(several)} models of learning seed {seed} in one mean: {', '.join(several)}")
    return found
