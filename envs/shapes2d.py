"""Plane geometry whose edge cases decide collisions. Source: spec, common.md section 5."""

from dataclasses import dataclass
from math import atan2, cos, hypot, sin
from typing import TypeAlias

Point: TypeAlias = tuple[float, float]

TOLERANCE = 1e-6  # by which a projected point may miss a segment


def segments_cross(a: Point, b: Point, c: Point, d: Point) -> bool:
    """Say whether segments ab and cd cross; touching and collinear overlap do not count."""
    return (_side(c, d, a) * _side(c, d, b) < 0) and (_side(a, b, c) * _side(a, b, d) < 0)


def _side(a: Point, b: Point, c: Point) -> int:
    """Return the sign of the orientation of c seen from segment ab."""
    value = (a[0] - b[0]) * (a[1] - c[1]) - (a[0] - c[0]) * (a[1] - b[1])
    return (value > 0) - (value < 0)


@dataclass(frozen=True, slots=True)
class Circle:
    """A disc by its center and radius."""

    x: float
    y: float
    radius: float

    def contains(self, point: Point) -> bool:
        """Say whether a point is inside or on the border."""
        return (point[0] - self.x) ** 2 + (point[1] - self.y) ** 2 <= self.radius**2


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

    def reach(self) -> float:
        """Return the radius of the circumscribed circle."""
        return hypot(self.width / 2, self.height / 2)

    def rotated(self, pivot: Point, angle: float) -> "Rectangle":
        """Return the rectangle turned counter-clockwise about a point."""
        c, s = cos(angle), sin(angle)

        def turn(point: Point) -> Point:
            dx, dy = point[0] - pivot[0], point[1] - pivot[1]
            return dx * c - dy * s + pivot[0], dx * s + dy * c + pivot[1]

        vertices = self.vertices()
        (x, y), (x3, y3) = turn(vertices[0]), turn(vertices[3])
        return Rectangle(x, y, self.width, self.height, atan2(y3 - y, x3 - x))


def segment_meets_rectangle(a: Point, b: Point, rectangle: Rectangle) -> bool:
    """Say whether a segment ends in the rectangle or crosses one of its edges."""
    if rectangle.contains(a) or rectangle.contains(b):
        return True
    vertices = rectangle.vertices()
    return any(segments_cross(a, b, vertices[i - 1], vertices[i]) for i in range(4))


def rectangles_meet(one: Rectangle, two: Rectangle) -> bool:
    """Say whether two rectangles overlap: crossing edges, or one holds the other's center."""
    (x1, y1), (x2, y2) = one.center(), two.center()
    if not (x1 - x2) ** 2 + (y1 - y2) ** 2 < (one.reach() + two.reach()) ** 2:
        return False
    first, second = one.vertices(), two.vertices()
    crossing = any(
        segments_cross(first[i - 1], first[i], second[j - 1], second[j]) for i in range(4) for j in range(4)
    )
    return crossing or one.contains((x2, y2)) or two.contains((x1, y1))


def circles_meet(one: Circle, two: Circle) -> bool:
    """Say whether two discs overlap; touching does not count."""
    return (one.x - two.x) ** 2 + (one.y - two.y) ** 2 < (one.radius + two.radius) ** 2


def segment_meets_circle(a: Point, b: Point, circle: Circle) -> bool:
    """Say whether a segment has a point in a disc."""
    if circle.contains(a) or circle.contains(b):
        return True
    ex, ey = b[0] - a[0], b[1] - a[1]
    square = ex * ex + ey * ey
    if square == 0:
        return False
    share = ((circle.x - a[0]) * ex + (circle.y - a[1]) * ey) / square
    near = a[0] + ex * share, a[1] + ey * share
    detour = hypot(a[0] - near[0], a[1] - near[1]) + hypot(near[0] - b[0], near[1] - b[1])
    return abs(detour - hypot(ex, ey)) < TOLERANCE and circle.contains(near)


def rectangle_meets_circle(rectangle: Rectangle, circle: Circle) -> bool:
    """Say whether a rectangle and a disc overlap."""
    far = rectangle.width + rectangle.height + circle.radius  # a cheap bound first: most pairs are far apart
    if abs(rectangle.x - circle.x) > far or abs(rectangle.y - circle.y) > far:
        return False
    x, y = rectangle.center()
    if not (x - circle.x) ** 2 + (y - circle.y) ** 2 < (rectangle.reach() + circle.radius) ** 2:
        return False
    if rectangle.contains((circle.x, circle.y)):
        return True
    vertices = rectangle.vertices()
    return any(segment_meets_circle(vertices[i - 1], vertices[i], circle) for i in range(4))
