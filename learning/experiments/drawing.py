"""The paper's main figure: tasks solved over the number of demonstrations. Source: spec, baselines.md."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from bpns.learning.experiments.tables import Row, base
from bpns.symbolic.compare.drawing import FORMATS, picture_format
from bpns.symbolic.errors import InputError, MissingPackage
from bpns.symbolic.files import replacing

try:
    import matplotlib
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
except ImportError as error:
    raise MissingPackage("pictures need matplotlib: pip install 'bpns[plots]'") from error

__all__ = ["draw_results", "picture_format"]

COLORS = {
    "BPNS": "darkgreen",
    "BPNS No Subgoal": "darkorange",
    "GNN Meta": "blue",
    "GNN Meta No Subgoal": "purple",
    "GNN BC": "gold",
    "Abstract Plans=1": "gray",
    "Samples=1": "brown",
}
OTHERS = "teal"
DASHES = ("-", "--", ":", "-.")  # for lines of one colour, such as another preset
WIDTHS = (4.5, 1.2)  # of the first line and of the last
SIZE = (2.5, 5.0)  # inches of a panel: 10 x 5 for the paper's four environments
COLUMN = 2.2  # inches of the legend's columns, about
DPI = 150


def draw_results(path: Path, found: Mapping[str, Sequence[Row]]) -> None:
    """Draw one panel an environment as .png, .svg or .pdf; the same bytes each time.

    Only what was measured is drawn; error bars are population standard deviations over runs. What was not
    learned, such as an oracle, has no number of demonstrations and is a level line. Raises InputError where
    nothing was learned at all.
    """
    suffix = picture_format(path)
    learned = any(row.run.origin.demonstrations is not None for rows in found.values() for row in rows)
    panels = {name: lines for name, rows in found.items() if (lines := _lines(rows))}
    if not learned:
        raise InputError("nothing to draw: no results of models whose number of demonstrations is known")
    with matplotlib.rc_context():
        matplotlib.rcdefaults()  # whatever the user's own settings are
        matplotlib.rcParams["svg.hashsalt"] = "bpns"
        figure = _figure(panels)
        with replacing(path) as temporary:
            figure.savefig(temporary, format=suffix[1:], metadata=FORMATS[suffix])


def _lines(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """Return the rows of each line by its label, from few demonstrations to many."""
    lines: dict[str, list[Row]] = {}
    for row in rows:
        lines.setdefault(row.label, []).append(row)
    known = {label: [r for r in of if r.run.origin.demonstrations is not None] for label, of in lines.items()}
    return {label: known[label] or of for label, of in lines.items()}


def _figure(panels: Mapping[str, Mapping[str, Sequence[Row]]]) -> Figure:
    width = max(SIZE[0] * len(panels), SIZE[1])
    figure = Figure((width, SIZE[1]), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    styles = dict(_styles(panels))
    drawn: dict[str, Artist] = {}
    grid = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
    for axes, (environment, lines) in zip(grid, panels.items(), strict=True):
        for label in styles:  # in this order, so that the thinner ones are on top
            if label in lines:
                drawn[label] = _draw_line(axes, lines[label], styles[label])
        axes.set_title(environment)
        axes.set_xlabel("Number of Demonstrations")
        axes.set_ylim(-5, 110)
        axes.set_xlim(left=0)
    grid[0].set_ylabel("% Evaluation Tasks Solved")
    columns = max(1, min(len(drawn), int(width / COLUMN)))
    figure.legend(drawn.values(), drawn.keys(), loc="outside lower center", ncols=columns)
    return figure


def _styles(panels: Mapping[str, Mapping[str, Sequence[Row]]]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Give each label a colour, the paper's where it has one, dashes and a width: alike in all panels.

    Each line is thinner than those before it, so that equal ones do not hide each other.
    """
    labels = {label: base(rows[0].run) for lines in panels.values() for label, rows in lines.items()}
    used: dict[str, int] = {}
    for number, (label, name) in enumerate(labels.items()):
        color = COLORS.get(name, OTHERS)
        dashes = DASHES[used.setdefault(color, 0) % len(DASHES)]
        used[color] += 1
        thinner = (WIDTHS[0] - WIDTHS[1]) * number / max(1, len(labels) - 1)
        yield label, {"color": color, "linestyle": dashes, "linewidth": WIDTHS[0] - thinner}


def _draw_line(axes: Axes, rows: Sequence[Row], style: Mapping[str, Any]) -> Artist:
    counts = [count for row in rows if (count := row.run.origin.demonstrations) is not None]
    if not counts:
        return axes.axhline(rows[0].summary.solved[0], **style)
    drawn = axes.errorbar(
        counts,
        [row.summary.solved[0] for row in rows],
        [row.summary.solved[1] for row in rows],
        elinewidth=1,
        marker="o",
        markersize=4,
        capsize=3,
        **style,
    )
    line: Artist = drawn.lines[0]
    return line
