"""A picture of which operators enable which: what ``describe`` is in words. Needs matplotlib."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import networkx as nx
import numpy as np

from bpns.symbolic.compare.layout import Array, Size, lay_out
from bpns.symbolic.errors import InputError, MissingPackage
from bpns.symbolic.files import replacing
from bpns.symbolic.operators import Operator

try:
    import matplotlib
    from matplotlib.axes import Axes
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.patches import FancyArrowPatch, FancyBboxPatch
    from matplotlib.path import Path as Line
except ImportError as error:
    raise MissingPackage("pictures need matplotlib: pip install 'bpns[plots]'") from error

FORMATS = {".png": {"Software": None}, ".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
COLORS = (
    "#1f6fb4 #c44e00 #2a8a3a #b0263a #7a52b0 #7d4a3c #c2468f #4d5965 #857500 #00838c".split()
)  # of operators, and of the arrows from them
NAME = {"fontsize": 11, "fontweight": "bold"}
TYPES = {"fontsize": 9}
LABEL = {"fontsize": 9, "linespacing": 1.1}
DPI = 200
MARGIN = 0.12  # inches


def picture_format(path: Path) -> str:
    """Return a picture's format; raise InputError for a file's name that says none of ours."""
    if path.suffix.lower() not in FORMATS:
        raise InputError(f"cannot draw a picture as '{path.name}': use {', '.join(sorted(FORMATS))}")
    return path.suffix.lower()


def draw_operators(path: Path, operators: Sequence[Operator], graph: "nx.DiGraph[str]") -> None:
    """Draw the graph of ``enabling_graph`` as .png, .svg or .pdf; the same bytes each time."""
    suffix = picture_format(path)
    if not operators:
        raise InputError("there are no operators to draw")
    with matplotlib.rc_context():
        matplotlib.rcdefaults()  # whatever the user's own settings are
        matplotlib.rcParams["svg.hashsalt"] = "bpns"
        figure = _figure(operators, graph)
        with replacing(path) as temporary:
            figure.savefig(temporary, format=suffix[1:], metadata=FORMATS[suffix])


def _figure(operators: Sequence[Operator], graph: "nx.DiGraph[str]") -> Figure:
    figure = Figure(dpi=DPI)
    FigureCanvasAgg(figure)
    types = {o.name: ", ".join(v.type.name for v in o.parameters) for o in operators}
    texts = {edge: "\n".join(graph.edges[edge]["predicates"]) for edge in graph.edges}
    boxes = {name: _box_size(figure, name, types[name]) for name in graph}
    labels = {edge: _text_size(figure, text, LABEL) for edge, text in texts.items()}
    layout = lay_out(graph, boxes, labels)
    corners = [c + s * np.array(boxes[n]) / 2 for n, c in layout.nodes.items() for s in (-1, 1)]
    corners += [c + s * np.array(labels[e]) / 2 for e, c in layout.labels.items() for s in (-1, 1)]
    points = np.concatenate([np.array(corners), *layout.arrows.values()])
    low, high = points.min(axis=0) - MARGIN, points.max(axis=0) + MARGIN
    figure.set_size_inches(*(high - low))
    axes = figure.add_axes((0, 0, 1, 1), xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    axes.set_axis_off()
    colors = {name: COLORS[number % len(COLORS)] for number, name in enumerate(graph)}
    for edge, arrow in layout.arrows.items():
        axes.add_patch(
            FancyArrowPatch(
                path=Line(arrow),
                color=colors[edge[0]],
                arrowstyle="-|>",
                mutation_scale=12,
                shrinkA=0,
                shrinkB=0,
            )
        )
    for edge, (x, y) in layout.labels.items():
        back = {"facecolor": "white", "edgecolor": "none", "pad": 0.5, "alpha": 0.9}
        axes.text(
            x, y, texts[edge], LABEL, color=colors[edge[0]], ha="center", va="center", bbox=back, zorder=3
        )
    for name, centre in layout.nodes.items():
        _draw_box(axes, centre, boxes[name], name, types[name], colors[name])
    return figure


def _text_size(figure: Figure, text: str, font: dict[str, Any]) -> Size:
    """Return a text's width and height in inches."""
    drawn = figure.text(0, 0, text, font)
    extent = drawn.get_window_extent()
    drawn.remove()
    return extent.width / figure.dpi, extent.height / figure.dpi


def _box_size(figure: Figure, name: str, types: str) -> Size:
    widths = [_text_size(figure, name, NAME)[0], _text_size(figure, types or " ", TYPES)[0]]
    return max(widths) + 0.2, 0.46


def _draw_box(axes: Axes, centre: Array, size: Size, name: str, types: str, color: str) -> None:
    """Draw a node: its name, below it its parameters' types."""
    corner = centre - np.array(size) / 2
    axes.add_patch(
        FancyBboxPatch(
            (corner[0], corner[1]),
            *size,
            boxstyle="round,pad=0,rounding_size=0.08",
            facecolor="#f4f6f8",
            edgecolor=color,
            linewidth=1.6,
            zorder=4,
        )
    )
    x, y = centre
    axes.text(x, y + (0.09 if types else 0), name, NAME, ha="center", va="center", color=color, zorder=5)
    axes.text(x, y - 0.1, types, TYPES, ha="center", va="center", color="#333333", zorder=5)
