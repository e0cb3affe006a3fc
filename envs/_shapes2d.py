"""Plane geometry whose edge cases decide collisions. Source: spec, common.md section 5."""

from dataclasses import dataclass
from math import cos, sin
from typing import TypeAlias

Point: TypeAlias = tuple[float, float]


def segments_cross(a: Point, b: Point, c: Point, d: Point) -> bool:
    """Say whether segments ab and cd cross; touching and collinear overlap do not count."""
    return (_side(c, d, a) * _side(c, d, b) < 0) and (_side(a, b, c) * _side(a, b, d) < 0)


def _side(a: Point, b: Point, c: Point) -> int:
    """Return the sign of the orientation of c seen from segment ab."""
    value = (a[0] - b[0]) * (a[1] - c[1]) - (a[0] - c[0]) * (a[1] - b[1])
    return (value > 0) - (value < 0)


@dataclass(frozen=True, slots=True)
class Rectangle:
    """A rectangle by one corner, its extent and a counter-clockwise rotation about that corner [rad]."""

    x: float
    y: float
    width: float
    height: float
    theta: float = 0.0

    def vertices(self) -> tuple[Point, Point, Point, Point]:
        """Return the corners; consecutive ones share an edge."""
        c, s = cos(self.theta), sin(self.theta)
        corners = ((0.0, 0.0), (0.0, self.height), (self.width, self.height), (self.width, 0.0))
        p, q, r, t = ((self.x + a * c - b * s, self.y + a * s + b * c) for a, b in corners)
        return p, q, r, t

    def center(self) -> Point:
        """Return the mean of the vertices."""
        vertices = self.vertices()
        return sum(v[0] for v in vertices) / 4, sum(v[1] for v in vertices) / 4

    def contains(self, point: Point) -> bool:
        """Say whether a point is inside or on the border."""
        dx, dy = point[0] - self.x, point[1] - self.y
        c, s = cos(self.theta), sin(self.theta)
        return 0 <= dx * c + dy * s <= self.width and 0 <= dy * c - dx * s <= self.height


def segment_meets_rectangle(a: Point, b: Point, rectangle: Rectangle) -> bool:
    """Say whether a segment ends in the rectangle or crosses one of its edges."""
    if rectangle.contains(a) or rectangle.contains(b):
        return True
    vertices = rectangle.vertices()
    return any(segments_cross(a, b, vertices[i - 1], vertices[i]) for i in range(4))


def rectangles_meet(one: Rectangle, two: Rectangle) -> bool:
    """Say whether two rectangles overlap: crossing edges, or one holds the other's center."""
    (x1, y1), (x2, y2) = one.center(), two.center()
    reach = ((one.width / 2) ** 2 + (one.height / 2) ** 2) ** 0.5
    reach += ((two.width / 2) ** 2 + (two.height / 2) ** 2) ** 0.5
    if not (x1 - x2) ** 2 + (y1 - y2) ** 2 < reach**2:
        return False
    first, second = one.vertices(), two.vertices()
    crossing = any(
        segments_cross(first[i - 1], first[i], second[j - 1], second[j]) for i in range(4) for j in range(4)
    )
    return crossing or one.contains((x2, y2)) or two.contains((x1, y1))
