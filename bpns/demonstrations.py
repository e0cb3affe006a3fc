"""Demonstrations: made by the environment's own skills, from files, or from arrays."""

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from bpns.learning.data import arrays, demonstrations, files
from bpns.learning.data.demonstrations import Demonstrations
from bpns.symbolic.errors import InputError
from bpns.symbolic.files import check_output
from bpns.symbolic.pddl.write import model_names
from bpns.symbolic.skills.environment import domain_of
from bpns.world import World, load_environment


def collect(
    world: World,
    count: int = 1000,
    seed: int = 0,
    workers: int = 1,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Demonstrations:
    """Let the environment's oracle skills solve the first ``count`` train tasks; keep the trajectories.

    Tasks that they do not solve are in ``failures``, with why. The result does not depend on ``workers``, a
    number of processes. Raises InputError where there are no oracle skills, or where names are not fit for
    PDDL. Source: spec, algorithm.md section 1.

    >>> import bpns
    >>> bpns.collect(bpns.load_environment("cover"), count=5, seed=0)
    <5 demonstrations of 5 tasks in cover>
    """
    skills = world.environment.oracle_skills
    if not skills:
        raise InputError(
            f"environment '{world.name}' has no oracle skills to demonstrate with: "
            "give it oracle_skills, or bring recordings (bpns.demonstrations_from_arrays)"
        )
    model_names(domain_of(world.environment, (skill.operator for skill in skills)))  # fit for PDDL later
    return demonstrations.collect(world.environment, count, seed, workers, progress)


def demonstrations_from_arrays(world: World, recordings: Iterable[Mapping[str, Any]]) -> Demonstrations:
    """Make demonstrations of what was recorded elsewhere, one mapping each.

    "objects": {name: type}; "states": (T+1, F) features of these objects in order, one after the other;
    "actions": (T, A); "goal": text as for ``World.own_task``, or [[predicate, object, ...], ...]. Optional:
    "skills", for each action [given skill, object, ...] or None. Raises InputError for shapes that do not
    fit, numbers that are not finite, and names that there are not.

    >>> import bpns, numpy as np
    >>> world = bpns.load_environment("cover")
    >>> demo = bpns.collect(world, count=1).demonstrations[0]
    >>> objects = demo.task.init.objects
    >>> recording = {
    ...     "objects": {o.name: o.type.name for o in objects},
    ...     "states": np.array([state.vector(objects) for state in demo.trajectory.states]),
    ...     "actions": np.array(demo.trajectory.actions),
    ...     "goal": "Covers(block0, target0)",
    ... }
    >>> bpns.demonstrations_from_arrays(world, [recording])
    <1 demonstrations of 1 tasks in cover>
    """
    found = [
        arrays.demonstration(world.environment, number, recording)
        for number, recording in enumerate(recordings)
    ]
    return Demonstrations(world.name, 0, len(found), tuple(found), ())


def read_demonstrations(path: Path | str, world: World | None = None) -> Demonstrations:
    """Read demonstrations that ``write_demonstrations`` or ``bpns demos`` wrote.

    Without a world: in the one that the file names, see ``world_of``. Raises InputError where the file is
    broken or of another environment.

    >>> import bpns
    >>> world = bpns.load_environment("cover")
    >>> bpns.write_demonstrations("cover.h5", bpns.collect(world, count=5), world)
    >>> bpns.read_demonstrations("cover.h5")
    <5 demonstrations of 5 tasks in cover>
    """
    return files.read_demonstrations(Path(path), (world or world_of(path)).environment)


def world_of(demonstrations_file: Path | str) -> World:
    """Return the world that a file of demonstrations is of. Raises InputError as ``read_demonstrations``.

    >>> import bpns
    >>> world = bpns.load_environment("cover")
    >>> bpns.write_demonstrations("cover.h5", bpns.collect(world, count=5), world, overwrite=True)
    >>> bpns.world_of("cover.h5").asked
    'cover'
    """
    asked, folders = files.read_environment_name(Path(demonstrations_file))
    return load_environment(asked, folders)


def write_demonstrations(
    path: Path | str, data: Demonstrations, world: World, overwrite: bool = False
) -> None:
    """Write demonstrations as one HDF5 file, in one piece; the same ones give the same bytes.

    Raises InputError where the file exists and is not to be overwritten, or cannot be written.

    >>> import bpns
    >>> world = bpns.load_environment("cover")
    >>> bpns.write_demonstrations("cover.h5", bpns.collect(world, count=5), world, overwrite=True)
    """
    check_output(Path(path), overwrite)
    files.write_demonstrations(Path(path), data, world.environment, world.asked, world.folder)
