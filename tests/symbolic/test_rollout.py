"""When a skill is over."""

import numpy as np

from bpns.symbolic.operators import Operator
from bpns.symbolic.skills.rollout import GroundSkill, Rollout
from bpns.symbolic.skills.skill import NoSampler, Skill
from bpns.symbolic.structs import Variable
from tests.toy import DOOR, DOOR_0, IS_OPEN, Repeat, Toy

FROM, TO = Variable("?from", DOOR), Variable("?to", DOOR)
WALK = Operator(
    "walk", (FROM, TO), frozenset(), frozenset({IS_OPEN.lifted(TO)}), frozenset({IS_OPEN.lifted(FROM)})
)


def test_an_atom_deleted_and_added_is_waited_for_as_added() -> None:
    """One object in two places: the roll-out once waited for its atom to vanish."""
    world = Toy()
    task = world.sample_task("test", 0, np.random.default_rng(0))
    opened = task.init.changed({"door0": (1.0,)})
    skill = GroundSkill(Skill(WALK, Repeat(1), NoSampler()), WALK.ground((DOOR_0, DOOR_0)))
    assert skill.terminal(world, opened)
    assert not skill.terminal(world, task.init)
    rollout = skill.roll_out(world, opened, np.zeros(0, np.float32), 5)
    assert isinstance(rollout, Rollout)
    assert not rollout.trajectory.actions
