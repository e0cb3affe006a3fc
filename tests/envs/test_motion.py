from itertools import pairwise
from math import hypot, inf

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from bpns.envs.doors.motion import Free, line, plan_motion
from bpns.envs.shapes2d import Circle, Point

STEP = 0.1
ROUNDING = 1e-9
START, TARGET = (0.1, 0.5), (0.9, 0.5)


def free_of(*discs: Circle) -> Free:
    """Free is where no disc is, in the unit square."""

    def free(point: Point) -> bool:
        return all(0 <= v <= 1 for v in point) and not any(disc.contains(point) for disc in discs)

    return free


def plan(free: Free, start: Point = START, target: Point = TARGET, seed: int = 0) -> list[Point] | None:
    rng = np.random.default_rng(seed)

    def sample() -> Point:
        return rng.uniform(), rng.uniform()

    return plan_motion(start, target, free, sample, STEP, rng)


def lengths(path: list[Point]) -> list[float]:
    return [hypot(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(path)]


def wall(*, gap: bool) -> Free:
    """A wall across the square, 0.1 thick, open at the top or not."""
    return lambda point: (
        all(0 <= v <= 1 for v in point) and not (0.45 <= point[0] <= 0.55 and (point[1] < 0.9 or not gap))
    )


coordinate = st.floats(0, 1)
point = st.tuples(coordinate, coordinate)
disc = st.builds(Circle, coordinate, coordinate, st.floats(0.02, 0.25))


@settings(max_examples=40)
@given(st.lists(disc, max_size=4), point, point, st.integers(0, 100))
@example([Circle(0.5, 0.5, 0.25)], START, TARGET, 0)
@example([Circle(0.5, 0.3, 0.2), Circle(0.5, 0.7, 0.15)], START, TARGET, 1)
def test_a_path_leads_from_start_to_target_in_short_free_steps(
    discs: list[Circle], start: Point, target: Point, seed: int
) -> None:
    free = free_of(*discs)
    path = plan(free, start, target, seed)
    if path is None:
        assert not (free(start) and free(target) and all(map(free, line(start, target, STEP))))
        return
    assert path[0] == start
    assert path[-1] == target
    assert all(map(free, path))
    assert max(lengths(path)) <= STEP + ROUNDING
    assert plan(free, start, target, seed) == path


@given(point, point)
def test_a_line_ends_at_its_end_in_equal_steps(start: Point, end: Point) -> None:
    points = line(start, end, STEP)
    assert points[-1] == end
    steps = lengths([start, *points])
    assert max(steps) <= STEP + ROUNDING
    assert max(steps) - min(steps) < ROUNDING
    assert len(points) == 1 or min(steps) >= STEP / 2 - ROUNDING  # no more of them than needed


def test_a_free_straight_line_is_the_path_and_draws_nothing() -> None:
    rng = np.random.default_rng(0)
    path = plan_motion(START, TARGET, free_of(), pytest.fail, STEP, rng)
    assert path == [START, *line(START, TARGET, STEP)]
    assert rng.integers(1000) == np.random.default_rng(0).integers(1000)


def test_start_and_target_must_be_free() -> None:
    for place in (START, TARGET):
        assert plan(free_of(Circle(*place, 0.01))) is None


def test_there_is_no_way_through_a_wall() -> None:
    assert plan(wall(gap=False)) is None


@pytest.mark.parametrize("seed", range(5))
def test_the_way_around_a_wall_is_found_from_either_side(seed: int) -> None:
    for start, target in ((START, TARGET), (TARGET, START)):
        path = plan(wall(gap=True), start, target, seed)
        assert path is not None
        assert (path[0], path[-1]) == (start, target)
        assert all(map(wall(gap=True), path))
        assert max(y for _, y in path) >= 0.9
        assert max(lengths(path)) <= STEP + ROUNDING


def test_the_path_depends_on_the_seed_alone() -> None:
    paths = [plan(wall(gap=True), seed=seed) for seed in (0, 0, 1)]
    assert paths[0] == paths[1] != paths[2]


def test_shortcuts_make_paths_shorter(monkeypatch: pytest.MonkeyPatch) -> None:
    smooth = [plan(wall(gap=True), seed=seed) or [] for seed in range(10)]
    monkeypatch.setattr("bpns.envs.doors.motion.SMOOTHING_TRIES", 0)
    rough = [plan(wall(gap=True), seed=seed) or [] for seed in range(10)]
    totals = [(sum(lengths(a)) or inf, sum(lengths(b))) for a, b in zip(smooth, rough, strict=True)]
    assert all(a <= b + ROUNDING for a, b in totals)
    assert sum(a for a, _ in totals) < 0.9 * sum(b for _, b in totals)
    assert all(len(a) <= len(b) for a, b in zip(smooth, rough, strict=True))
