"""Learning: demonstrations -> a model, by any approach."""

import os
import platform
import time
from collections.abc import Callable
from dataclasses import asdict, replace
from importlib.metadata import version
from typing import Any, Literal

from bpns import __version__
from bpns.learning import approaches
from bpns.learning.approaches import Learn, Learned, Learning
from bpns.learning.data.demonstrations import Demonstrations
from bpns.learning.models.files import SkillEntry
from bpns.learning.models.save import entry_of
from bpns.model import Model
from bpns.symbolic.errors import InputError
from bpns.symbolic.pddl.write import model_names
from bpns.symbolic.skills.environment import domain_of
from bpns.world import World


def learn(
    world: World,
    demonstrations: Demonstrations,
    approach: str = "bpns",
    seed: int | None = None,
    preset: Literal["default", "paper"] = "default",
    min_share: float | None = None,
    device: str = "auto",
    workers: int = 1,
    progress: Callable[[int, int], None] = lambda done, total: None,
    command: str = "bpns.learn",
) -> Model:
    """Learn a model: operators, and a policy and a sampler for each; or what another approach learns.

    ``approach`` is a name as in ``bpns.approaches()``, or "module:attribute"; ``seed`` the demonstrations'
    own if none is given. ``preset`` "paper" learns the paper's operators with its training, for minutes.
    ``min_share`` is the share of all segments below which an operator is dropped (0.01; 0: no filter).
    ``device`` is of graph networks: "cpu", "cuda" or "auto". ``workers`` (processes) change the time alone.
    Raises InputError where nothing can be learned. Source: spec, algorithm.md sections 3 to 6.

    >>> import bpns
    >>> world = bpns.load_environment("cover")
    >>> model = bpns.learn(world, bpns.collect(world, count=20), seed=0)
    >>> print(model.operators["Op0"])
    Op0:
      Parameters: [?x0:block, ?x1:gripper]
      Preconditions: [HandEmpty(), IsBlock(?x0:block)]
      Add Effects: [Holding(?x0:block, ?x1:gripper)]
      Delete Effects: [HandEmpty()]
    """
    learn_by = _chosen(approach, min_share)
    model_names(domain_of(world.environment, ()))  # before minutes of training: will this be fit for PDDL?
    seed = demonstrations.seed if seed is None else seed
    how = _settings(preset, min_share, device, seed, workers, progress)
    start, start_cpu = time.perf_counter(), _cpu_seconds()
    learned = learn_by(world.environment, demonstrations, how)
    seconds, cpu_seconds = time.perf_counter() - start, _cpu_seconds() - start_cpu
    name = approach.replace("-", "_")
    return Model(
        world=world,
        label=name,
        approach=name,
        seed=seed,
        skills={one.skill.operator.name: one.skill for one in learned.skills},
        entries=_entries(learned),
        graph=learned.graph,
        training=learned.fit,
        run=_record(demonstrations, how, name, preset, command, seconds, cpu_seconds),
        header=_header(world, demonstrations, seed),
    )


def _chosen(approach: str, min_share: float | None) -> Learn:
    """Return how an approach learns; raise InputError where it does not, or has no operators to drop."""
    chosen = approaches.load(approach)
    if chosen.learn is None:
        raise InputError(f"'{approach}' learns nothing: {chosen.summary}")
    if min_share is not None and not chosen.skills:
        raise InputError(f"'{approach}' learns no operators: leave the least share out")
    return chosen.learn


def _entries(learned: Learned) -> dict[str, SkillEntry]:
    return {
        one.skill.operator.name: entry_of(one.skill, one.segments, one.demonstrations, one.fits)
        for one in learned.skills
    }


def _settings(
    preset: str,
    min_share: float | None,
    device: str,
    seed: int,
    workers: int,
    progress: Callable[[int, int], None],
) -> Learning:
    """Return how to learn; raise InputError for a preset that there is not."""
    from bpns.learning.graphs.training import GraphTraining, device_of  # torch: slow to import
    from bpns.learning.models.settings import SkillConfig

    if preset not in ("default", "paper"):
        raise InputError(f"no preset '{preset}' (have: default, paper)")
    skills = SkillConfig.paper() if preset == "paper" else SkillConfig()
    if min_share is not None:
        skills = replace(skills, min_share=min_share)
    graphs = GraphTraining() if preset == "paper" else GraphTraining.fast()
    return Learning(skills, graphs, seed, workers, str(device_of(device)), progress)


def _record(
    demonstrations: Demonstrations,
    how: Learning,
    approach: str,
    preset: str,
    command: str,
    seconds: float,
    cpu_seconds: float,
) -> dict[str, Any]:
    """Return what run.json says of a model: what made it, how, and of what."""
    return {
        "command": command,
        **_versions(),
        "approach": approach,
        "preset": preset,
        "settings": asdict(how.skills),
        "graphs": {**asdict(how.graphs), "device": how.device},
        "seed": how.seed,
        "demonstrations": {
            "seed": demonstrations.seed,
            "asked": demonstrations.asked,
            "given": len(demonstrations.demonstrations),
        },
        "seconds": round(seconds, 3),
        "cpu_seconds": round(cpu_seconds, 3),
    }


def _header(world: World, demonstrations: Demonstrations, seed: int) -> str:
    """Return what domain.pddl begins with."""
    return (
        f"Skills of environment {world.name}, learned by bpns {__version__} from "
        f"{len(demonstrations.demonstrations)} demonstrations\n"
        f"(demonstrations of seed {demonstrations.seed}, learning with seed {seed}). You may edit this file: "
        "keep the\noperators' names and the types of their parameters."
    )


def _versions() -> dict[str, str]:
    packages = ("numpy", "torch", "safetensors", "h5py")
    return {
        "bpns": __version__,
        "python": platform.python_version(),
        **{package: version(package) for package in packages},
    }


def _cpu_seconds() -> float:
    """Return the processor time of this process and of its workers that have ended."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system
