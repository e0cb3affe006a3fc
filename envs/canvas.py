"""A small canvas in world coordinates: drawn at twice the size and scaled down for smooth edges."""

from dataclasses import dataclass
from functools import cache
from typing import TypeAlias

from PIL import Image, ImageDraw, ImageFont

Color: TypeAlias = tuple[int, int, int]

SMOOTH = 2
CAPTION_HEIGHT = 64  # pixels above the picture


@cache
def _font(size: int) -> ImageFont.ImageFont | ImageFont.FreeTypeFont:
    return ImageFont.load_default(size)


@dataclass(frozen=True, slots=True)
class Canvas:
    """Maps the world box left..right, bottom..top to pixels; y points up. Build it with ``blank``."""

    left: float
    right: float
    bottom: float
    top: float
    image: Image.Image
    pixels_per_unit: float

    @classmethod
    def blank(cls, left: float, right: float, bottom: float, top: float, width: int) -> "Canvas":
        """Return a white canvas, ``width`` pixels wide."""
        scale = width * SMOOTH / (right - left)
        height = round((top - bottom) / (right - left) * width) + CAPTION_HEIGHT
        size = (width * SMOOTH, height * SMOOTH)
        return cls(left, right, bottom, top, Image.new("RGB", size, "white"), scale)

    def pixel(self, x: float, y: float) -> tuple[float, float]:
        """Return the pixel at a point of the world."""
        return (
            (x - self.left) * self.pixels_per_unit,
            (self.top - y) * self.pixels_per_unit + CAPTION_HEIGHT * SMOOTH,
        )

    def _pen(self) -> ImageDraw.ImageDraw:
        return ImageDraw.Draw(self.image, "RGBA")

    def polygon(
        self,
        points: list[tuple[float, float]],
        fill: Color,
        opacity: float = 1.0,
        edge: Color | None = None,
        thickness: float = 2,
    ) -> None:
        """Fill a polygon."""
        pixels = [self.pixel(*p) for p in points]
        self._pen().polygon(pixels, fill=(*fill, round(255 * opacity)))
        if edge is not None:
            self._pen().line([*pixels, pixels[0]], fill=edge, width=round(thickness * SMOOTH), joint="curve")

    def rectangle(
        self,
        x: float,
        y: float,
        width: float,
        height: float,
        fill: Color,
        opacity: float = 1.0,
        edge: Color | None = None,
        thickness: float = 2,
    ) -> None:
        """Fill an upright rectangle whose lower left corner is (x, y)."""
        points = [(x, y), (x, y + height), (x + width, y + height), (x + width, y)]
        self.polygon(points, fill, opacity, edge, thickness)

    def line(
        self, start: tuple[float, float], end: tuple[float, float], color: Color, thickness: float
    ) -> None:
        """Draw a straight line; thickness in pixels."""
        ends = [self.pixel(*start), self.pixel(*end)]
        self._pen().line(ends, fill=color, width=round(thickness * SMOOTH))

    def disc(
        self,
        x: float,
        y: float,
        radius: float,
        fill: Color,
        opacity: float = 1.0,
        edge: Color | None = None,
        thickness: float = 2,
    ) -> None:
        """Draw a filled disc; radius in world units."""
        cx, cy = self.pixel(x, y)
        r = radius * self.pixels_per_unit
        self._pen().ellipse(
            (cx - r, cy - r, cx + r, cy + r),
            fill=(*fill, round(255 * opacity)),
            outline=edge,
            width=round(thickness * SMOOTH) if edge is not None else 0,
        )

    def text(self, x: float, y: float, text: str, size: int = 13, anchor: str = "mm") -> None:
        """Write text at a point of the world."""
        self._pen().text(self.pixel(x, y), text, fill=(40, 40, 40), font=_font(size * SMOOTH), anchor=anchor)

    def caption(self, lines: list[str]) -> None:
        """Write up to three lines above the picture, shortened where they do not fit."""
        for row, line in enumerate(lines[:3]):
            font = _font(13 * SMOOTH)
            while line and font.getlength(line) > self.image.width - 16 * SMOOTH:
                line = line[:-4] + "..." if not line.endswith("...") else line[:-7] + "..."
            self._pen().text((8 * SMOOTH, (6 + 18 * row) * SMOOTH), line, fill=(20, 20, 20), font=font)

    def finish(self) -> Image.Image:
        """Return the picture at its final size."""
        return self.image.reduce(SMOOTH)
