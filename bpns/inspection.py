"""Looking at things: environments, domains, plans, recordings, what is installed."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from bpns import envs
from bpns.learning import approaches as known_approaches
from bpns.model import Model
from bpns.symbolic import checkers as known_checkers
from bpns.symbolic import environment_check
from bpns.symbolic import planners as known_planners
from bpns.symbolic.checkers import reports
from bpns.symbolic.checkers.running import check
from bpns.symbolic.compare.difference import Difference, compare
from bpns.symbolic.environment_check import Finding
from bpns.symbolic.operators import Domain
from bpns.symbolic.pddl.read import read_domain
from bpns.symbolic.planners.protocol import About
from bpns.symbolic.skills import recording
from bpns.symbolic.skills.recording import Replay
from bpns.world import World


def planners() -> list[About]:
    """Return what each planner can do, with its licence; ``version`` is None where it is not installed.

    >>> [about.name for about in planners() if about.name.startswith("astar")]
    ['astar']
    """
    return known_planners.about()


def approaches() -> dict[str, str]:
    """Return the approaches that ``learn`` knows, each with a line on what it learns.

    >>> "gnn-meta" in approaches()
    True
    """
    found = {name: known_approaches.load(name) for name in known_approaches.names()}
    return {name.replace("_", "-"): one.summary for name, one in found.items() if one.learn}


def check_environment(environment: object, tasks: int = 5, seed: int = 0) -> list[Finding]:
    """Say what an environment promises and does not keep: one finding for each check.

    ``environment`` is a name, "module:attribute", or whatever is meant as one; exceptions that it raises
    become faults.

    >>> {finding.level for finding in check_environment("cover", tasks=1)}
    {'ok'}
    """
    found = envs.find(environment) if isinstance(environment, str) else environment
    subject = found.environment if isinstance(found, World) else found
    return list(environment_check.check(subject, tasks, seed))


def diff(before: Path | str | Domain | Model, after: Path | str | Domain | Model) -> Difference:
    """Say what differs between two domains, whatever their operators and parameters are called.

    Each is a file, a folder with domain.pddl, a domain or a model. ``difference_text`` puts it into words.

    >>> import bpns
    >>> model = bpns.oracle(bpns.load_environment("cover"))
    >>> print(bpns.difference_text(bpns.diff(model, model.renamed({"Pick": "Grasp"}))))
    same      Pick -> Grasp
    same      Place
    operators: 2 same, 0 changed, 0 removed, 0 added
    """
    return compare(domain_of_any(before), domain_of_any(after))


def domain_of_any(source: Path | str | Domain | Model) -> Domain:
    """Return the domain that a file, a folder, a domain or a model is or has. Internal."""
    if isinstance(source, Model):
        return source.domain
    if isinstance(source, Domain):
        return source
    path = Path(source)
    return read_domain(path / "domain.pddl" if path.is_dir() else path)


@dataclass(frozen=True, slots=True)
class Validation:
    """What checkers say of PDDL files and plans: all together, where they disagree, and each by itself."""

    outcome: reports.Outcome  # "valid", "invalid", "failed" (a checker), "unsupported"
    disagreements: tuple[str, ...]
    inputs: reports.Inputs
    reports: tuple[reports.Report, ...]


def checkers() -> list[str]:
    """Return the names of the checkers, ours first, installed or not.

    >>> checkers()
    ['bpns', 'kairos', 'unified_planning', 'val']
    """
    return known_checkers.names()


def validate(
    domain: Path | str,
    problem: Path | str | None = None,
    plans: Sequence[Path | str] = (),
    checkers: Sequence[str] = (),
    timeout: float = 60.0,
) -> Validation:
    """Let checkers look at a domain, a problem and plan files: our reader and all others that are installed.

    ``checkers`` chooses some, ``timeout`` is in seconds for each. Raises InputError for files that cannot be
    read; faults in them are in the result.

    >>> import bpns
    >>> bpns.export(bpns.oracle(bpns.load_environment("cover")), "pddl", problems=1)
    >>> bpns.validate("pddl/domain.pddl", "pddl/p01.pddl", checkers=["bpns"]).outcome
    'valid'
    """
    inputs = reports.read_inputs(
        Path(domain), None if problem is None else Path(problem), [Path(plan) for plan in plans]
    )
    found = check(inputs, list(dict.fromkeys(checkers)) or known_checkers.names(), timeout)
    return Validation(
        reports.outcome(inputs.items, found),
        tuple(reports.disagreements(inputs.items, found)),
        inputs,
        tuple(found),
    )


def replay(file: Path | str, environment: str | None = None) -> Replay:
    """Compare a recording of a simulator with ours: tasks, demonstrations, transitions.

    Raises InputError where the file is no recording, or is of another environment.
    """
    found = recording.read_recording(Path(file))
    return recording.replay(found, envs.load(environment or str(found["environment"])))
