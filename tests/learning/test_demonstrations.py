from pathlib import Path

import h5py
import numpy as np
import pytest

from bpns import envs
from bpns.learning.data.demonstrations import Demonstrations, collect
from bpns.learning.data.files import read_demonstrations, write_demonstrations
from bpns.symbolic.errors import InputError
from bpns.symbolic.skills.environment import abstract, sample_tasks
from tests.toy import Toy

COVER = envs.load("cover")


def test_demonstrations_solve_their_tasks(demonstrations: Demonstrations) -> None:
    tasks = sample_tasks(COVER, "train", 40, 0)
    assert len(demonstrations.demonstrations) + len(demonstrations.failures) == 40
    for demonstration in demonstrations.demonstrations:
        states = demonstration.trajectory.states
        assert states[0].features == tasks[demonstration.task_index].init.features
        assert demonstration.task.goal <= abstract(COVER, states[-1])
        for before, action, after in zip(states, demonstration.trajectory.actions, states[1:], strict=False):
            assert COVER.simulate(before, action).features == after.features


def test_failures_say_why() -> None:
    data = collect(Toy(fails_below=2.0), 2, seed=0)
    assert data.demonstrations == ()
    assert data.failures == tuple((i, "none of 1 abstract plans could be refined") for i in range(2))


@pytest.mark.slow
def test_the_file_does_not_depend_on_workers(demonstrations: Demonstrations, tmp_path: Path) -> None:
    write_demonstrations(tmp_path / "one.h5", demonstrations, COVER)
    write_demonstrations(tmp_path / "two.h5", collect(COVER, 40, 0, workers=2), COVER)
    assert (tmp_path / "one.h5").read_bytes() == (tmp_path / "two.h5").read_bytes()


def test_a_file_gives_back_what_was_written(demonstrations: Demonstrations, tmp_path: Path) -> None:
    path = tmp_path / "new folder" / "demos.h5"
    write_demonstrations(path, demonstrations, COVER)
    again = read_demonstrations(path, COVER)
    assert (again.environment, again.seed, again.asked) == ("cover", 0, 40)
    assert again.failures == demonstrations.failures
    for one, two in zip(demonstrations.demonstrations, again.demonstrations, strict=True):
        assert (one.task_index, one.task.goal) == (two.task_index, two.task.goal)
        assert [s.features for s in one.trajectory.states] == [s.features for s in two.trajectory.states]
        assert np.array_equal(one.trajectory.actions, two.trajectory.actions)
        assert two.trajectory.actions[0].dtype == np.float32
    assert list(path.parent.iterdir()) == [path]


def test_a_file_explains_itself(demonstrations: Demonstrations, tmp_path: Path) -> None:
    write_demonstrations(tmp_path / "demos.h5", demonstrations, COVER)
    with h5py.File(tmp_path / "demos.h5") as file:
        assert "grasp" in file.attrs["types"]
        assert "HandEmpty" in file.attrs["predicates"]
        assert "states" in file.attrs["layout"]


def test_broken_and_foreign_files(demonstrations: Demonstrations, tmp_path: Path) -> None:
    path = tmp_path / "demos.h5"
    with pytest.raises(InputError, match="no such file"):
        read_demonstrations(path, COVER)
    write_demonstrations(path, demonstrations, COVER)
    with pytest.raises(InputError, match=r"demonstrations of 'cover', not of 'toy'"):
        read_demonstrations(path, Toy())
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    with pytest.raises(InputError, match="truncated"):
        read_demonstrations(path, COVER)
    path.write_bytes(b"no HDF5")
    with pytest.raises(InputError, match="not an HDF5 file"):
        read_demonstrations(path, COVER)
    path.write_bytes(data)
    with h5py.File(path, "r+") as file:
        file.attrs["types"] = "{}"
    with pytest.raises(InputError, match="its types differ"):
        read_demonstrations(path, COVER)
    path.write_bytes(data)
    with h5py.File(path, "r+") as file:
        del file["demonstrations/000000/actions"]
    with pytest.raises(InputError, match="broken demonstrations file"):
        read_demonstrations(path, COVER)
    damages = {
        "types": lambda file: file.attrs.__delitem__("types"),
        "seed": lambda file: file.attrs.__delitem__("seed"),
        "objects": lambda file: file["demonstrations/000000"].attrs.__setitem__("objects", "[1]"),
        "goal": lambda file: file["demonstrations/000000"].attrs.__setitem__("goal", "3"),
        "nan": lambda file: file["demonstrations/000000/states"].__setitem__((0, 0), np.nan),
    }
    for name, damage in damages.items():
        path.write_bytes(data)
        with h5py.File(path, "r+") as file:
            damage(file)
        with pytest.raises(InputError, match="broken demonstrations file"):
            print(name, read_demonstrations(path, COVER))
    path.write_bytes(data)
    with h5py.File(path, "r+") as file:
        narrow = file["demonstrations/000000/actions"][()][:, :2]
        del file["demonstrations/000000/actions"]
        file["demonstrations/000000/actions"] = narrow
    with pytest.raises(InputError, match="do not fit"):
        read_demonstrations(path, COVER)
    with h5py.File(path, "w") as file:
        file["other"] = [1]
    with pytest.raises(InputError, match="not of bpns demonstrations"):
        read_demonstrations(path, COVER)
