from math import pi

import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st
from shapely import affinity

from bpns.envs.shapes2d import (
    Circle,
    Rectangle,
    circles_meet,
    rectangle_meets_circle,
    rectangles_meet,
    segment_meets_circle,
    segment_meets_rectangle,
    segments_cross,
)

coordinate = st.floats(-3, 3).map(lambda v: round(v, 3))
point = st.tuples(coordinate, coordinate)
size = st.floats(0.1, 3).map(lambda v: round(v, 3))
rectangle = st.builds(Rectangle, coordinate, coordinate, size, size, st.floats(-pi, pi))
circle = st.builds(Circle, coordinate, coordinate, st.floats(0.05, 2).map(lambda v: round(v, 3)))
CLEAR = 1e-6  # shapes that just touch are decided by the specification's strictness, not by shapely


def as_polygon(shape: Rectangle) -> shapely.Polygon:
    upright = shapely.box(shape.x, shape.y, shape.x + shape.width, shape.y + shape.height)
    return affinity.rotate(upright, shape.theta, origin=(shape.x, shape.y), use_radians=True)


@given(rectangle, point)
def test_contains(shape: Rectangle, place: tuple[float, float]) -> None:
    polygon, dot = as_polygon(shape), shapely.Point(place)
    assume(polygon.exterior.distance(dot) > CLEAR)
    assert shape.contains(place) == polygon.contains(dot)


@given(rectangle)
def test_vertices(shape: Rectangle) -> None:
    assert shapely.Polygon(shape.vertices()).equals_exact(as_polygon(shape).normalize(), 1e-9) or (
        shapely.Polygon(shape.vertices()).symmetric_difference(as_polygon(shape)).area < 1e-9
    )


@given(point, point, point, point)
def test_segments(a: tuple, b: tuple, c: tuple, d: tuple) -> None:  # type: ignore[type-arg]
    one, two = shapely.LineString([a, b]), shapely.LineString([c, d])
    ends = [shapely.Point(p) for p in (a, b, c, d)]
    assume(a != b and c != d)
    assume(
        min(two.distance(ends[0]), two.distance(ends[1]), one.distance(ends[2]), one.distance(ends[3]))
        > CLEAR
    )
    assert segments_cross(a, b, c, d) == one.crosses(two)


@given(rectangle, point, point)
def test_segment_and_rectangle(shape: Rectangle, a: tuple, b: tuple) -> None:  # type: ignore[type-arg]
    polygon, line = as_polygon(shape), shapely.LineString([a, b])
    assume(polygon.exterior.distance(shapely.Point(a)) > CLEAR)
    assume(polygon.exterior.distance(shapely.Point(b)) > CLEAR)
    assume(all(line.distance(shapely.Point(v)) > CLEAR for v in polygon.exterior.coords))
    assert segment_meets_rectangle(a, b, shape) == polygon.intersects(line)


@given(rectangle, rectangle)
def test_rectangles(one: Rectangle, two: Rectangle) -> None:
    first, second = as_polygon(one), as_polygon(two)
    corners = [
        (polygon.exterior, shapely.Point(v))
        for polygon, other in ((first, second), (second, first))
        for v in other.exterior.coords
    ]
    assume(all(ring.distance(corner) > CLEAR for ring, corner in corners))
    assert rectangles_meet(one, two) == first.intersects(second)


def clear_of(length: float, limit: float) -> bool:
    return abs(length - limit) > CLEAR


@given(circle, point)
def test_a_circle_contains_what_is_near_its_centre(disc: Circle, place: tuple[float, float]) -> None:
    distance = shapely.Point(disc.x, disc.y).distance(shapely.Point(place))
    assume(clear_of(distance, disc.radius))
    assert disc.contains(place) == (distance < disc.radius)


@given(circle, circle)
def test_circles(one: Circle, two: Circle) -> None:
    distance = shapely.Point(one.x, one.y).distance(shapely.Point(two.x, two.y))
    assume(clear_of(distance, one.radius + two.radius))
    assert circles_meet(one, two) == (distance < one.radius + two.radius)


@given(point, point, circle)
def test_segment_and_circle(a: tuple, b: tuple, disc: Circle) -> None:  # type: ignore[type-arg]
    distance = shapely.LineString([a, b]).distance(shapely.Point(disc.x, disc.y))
    assume(clear_of(distance, disc.radius))
    assert segment_meets_circle(a, b, disc) == (distance < disc.radius)


@given(rectangle, circle)
def test_rectangle_and_circle(shape: Rectangle, disc: Circle) -> None:
    distance = as_polygon(shape).distance(shapely.Point(disc.x, disc.y))  # 0 inside
    assume(clear_of(distance, disc.radius))
    assert rectangle_meets_circle(shape, disc) == (distance < disc.radius)


@given(rectangle, point, st.floats(-2 * pi, 2 * pi))
def test_a_rectangle_is_rotated_about_a_point(
    shape: Rectangle, pivot: tuple[float, float], angle: float
) -> None:
    turned = shape.rotated(pivot, angle)
    expected = affinity.rotate(as_polygon(shape), angle, origin=pivot, use_radians=True)
    assert (turned.width, turned.height) == (shape.width, shape.height)
    assert -pi <= turned.theta <= pi
    for ours, theirs in zip((turned.vertices()[i] for i in (0, 3, 2, 1)), box_corners(expected), strict=True):
        assert ours == pytest.approx(theirs, abs=1e-9)


def box_corners(turned: shapely.Polygon) -> list[tuple[float, float]]:
    """The images of the lower left corner and the others counter-clockwise."""
    ring = list(turned.exterior.coords)[:4]  # shapely.box starts at the lower right
    return [ring[3], ring[0], ring[1], ring[2]]


def test_touching_decides_as_the_specification_says() -> None:
    disc = Circle(0, 0, 1)
    assert disc.contains((1, 0))
    assert not circles_meet(disc, Circle(2, 0, 1))
    assert segment_meets_circle((1, 0), (3, 0), disc)  # an end on the border
    assert segment_meets_circle((-3, 1), (3, 1), disc)  # a tangent
    assert rectangle_meets_circle(Rectangle(1, -1, 2, 2), disc)  # an edge is a tangent
    assert not rectangle_meets_circle(Rectangle(1.001, -1, 2, 2), disc)
    assert rectangle_meets_circle(Rectangle(-3, -3, 6, 6), disc)  # all of the circle inside
    assert rectangle_meets_circle(Rectangle(-0.1, -0.1, 0.2, 0.2), disc)  # all of the rectangle inside


def test_a_segment_without_length_is_a_point() -> None:
    assert segment_meets_circle((0.5, 0), (0.5, 0), Circle(0, 0, 1))
    assert not segment_meets_circle((1.5, 0), (1.5, 0), Circle(0, 0, 1))
