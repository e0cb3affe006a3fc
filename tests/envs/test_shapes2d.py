from math import pi

import shapely
from hypothesis import assume, given
from hypothesis import strategies as st
from shapely import affinity

from envs._shapes2d import Rectangle, rectangles_meet, segment_meets_rectangle, segments_cross

coordinate = st.floats(-3, 3).map(lambda v: round(v, 3))
point = st.tuples(coordinate, coordinate)
size = st.floats(0.1, 3).map(lambda v: round(v, 3))
rectangle = st.builds(Rectangle, coordinate, coordinate, size, size, st.floats(-pi, pi))
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
