"""Two kinds of charts that all figures are made of (matplotlib, an optional extra).

Colours are Okabe and Ito's, which people who do not tell red from green can tell apart; every series has a marker
or a dash of its own as well, so that the charts also read in grey.
"""

import io
from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")  # Okabe and Ito
MARKERS = ("o", "D", "s", "^", "v", "P")
DASHES = ("-", (0, (4, 1.6)), (0, (1.2, 1.2)), (0, (5, 1.4, 1.2, 1.4)), (0, (8, 2)))
DPI = 150
LEGEND_LETTERS = 110  # that fit below a chart, with six for each line
ROW_HEIGHT = 0.24  # inches a row


INK, SOFT, GRID, PAPER = "#20242a", "#5a626d", "#e3e6ea", "#ffffff"  # text, labels, lines, ground


@dataclass(frozen=True)
class Series:
    """One kind of mark; a row may have one value, several, or none."""

    label: str
    values: Sequence[Sequence[float]]  # of each row
    hollow: bool = False
    wrong: bool = False  # drawn as a cross in the colour of the text


@dataclass(frozen=True)
class Panel:
    title: str  # with the unit
    series: Sequence[Series]
    log: bool = False
    joined: bool = True  # a thin line from a row's smallest to its largest value


@dataclass(frozen=True)
class RowChart:
    """Dots on rows, rows grouped under headings, panels side by side."""

    rows: Sequence[tuple[str, str]]  # (heading, label)
    panels: Sequence[Panel]
    from_zero: bool = True


@dataclass(frozen=True)
class Curve:
    label: str
    x: Sequence[float]
    y: Sequence[float | None]
    colour: int
    dash: int


@dataclass(frozen=True)
class CurvePanel:
    title: str
    y_label: str
    x_label: str
    curves: Sequence[Curve]
    log_x: bool = False
    mark_x: float | None = None  # a thin upright line


@dataclass(frozen=True)
class CurveChart:
    """Panels of curves in a grid, the same kind of number in each row."""

    rows: Sequence[Sequence[CurvePanel]]
    legend_title: str = ""
    sizes: tuple[float, float] = field(default=(3.1, 2.1))  # inches a panel


Chart = RowChart | CurveChart


def has_numbers(chart: Chart) -> bool:
    """Whether there is anything to draw."""
    if isinstance(chart, RowChart):
        return any(some for panel in chart.panels for series in panel.series for some in series.values)
    return any(y is not None for row in chart.rows for panel in row for curve in panel.curves for y in curve.y)


def have_plots() -> bool:
    """Whether matplotlib is installed."""
    return find_spec("matplotlib") is not None


def as_png(chart: Chart) -> bytes:
    """The chart as a PNG file."""
    from matplotlib import rc_context

    settings: dict[Any, Any] = {
        "font.size": 9,
        "font.family": "DejaVu Sans",
        "text.color": INK,
        "axes.labelcolor": SOFT,
        "axes.edgecolor": GRID,
        "axes.facecolor": PAPER,
        "figure.facecolor": PAPER,
        "xtick.color": SOFT,
        "ytick.color": INK,
        "axes.grid": True,
        "grid.color": GRID,
        "grid.linewidth": 0.7,
        "axes.axisbelow": True,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.titlesize": 9,
        "axes.titleweight": "bold",
        "axes.titlelocation": "left",
        "legend.frameon": False,
        "legend.labelcolor": INK,
    }
    with rc_context(settings):
        figure = _rows(chart) if isinstance(chart, RowChart) else _curves(chart)
        stream = io.BytesIO()
        figure.savefig(stream, format="png", dpi=DPI, metadata={"Software": None})
    return stream.getvalue()


def _new(width: float, height: float, rows: int, columns: int, **more: Any) -> "tuple[Figure, Any]":
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(rows, columns, squeeze=False, **more)


def _places(rows: Sequence[tuple[str, str]]) -> tuple[list[float], list[tuple[str, float]], float]:
    """Heights of the rows and of the headings above each group, and the total."""
    at, heights, headings, last = 0.0, [], [], None
    for heading, _ in rows:
        if heading != last:
            at += 0.5 if last is not None else 0.0
            headings.append((heading, at))
            at += 1.0
            last = heading
        heights.append(at)
        at += 1.0
    return heights, headings, at


def _rows(chart: RowChart) -> "Figure":
    heights, headings, total = _places(chart.rows)
    figure, grid = _new(9.0, ROW_HEIGHT * total + 1.0, 1, len(chart.panels), sharey=True)
    for panel, axes in zip(chart.panels, grid[0], strict=True):
        _row_panel(axes, panel, heights, chart.from_zero)
    first = grid[0][0]
    words = [(height, label, False) for height, (_, label) in zip(heights, chart.rows, strict=True)]
    words += [(height, heading, True) for heading, height in headings]
    first.set_yticks([word[0] for word in words], [word[1] for word in words])
    for tick, word in zip(first.get_yticklabels(), words, strict=True):
        tick.set_fontweight("bold" if word[2] else "normal")
    first.set_ylim(total - 0.4, -0.6)
    handles: dict[str, Any] = {}
    for axes in grid[0]:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    if len(handles) > 1:
        figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=min(len(handles), 6))
    return figure


def _row_panel(axes: "Axes", panel: Panel, heights: Sequence[float], from_zero: bool) -> None:
    for height, *values in zip(heights, *(series.values for series in panel.series), strict=True):
        flat = [number for some in values for number in some]
        if panel.joined and len(flat) > 1:
            axes.plot([min(flat), max(flat)], [height, height], color=GRID, linewidth=2.2, zorder=1)
    for index, series in enumerate(panel.series):
        points = [(x, y) for y, some in zip(heights, series.values, strict=True) for x in some]
        colour = INK if series.wrong else COLOURS[index % len(COLOURS)]
        if not points:
            continue
        many = max((len(some) for some in series.values), default=0) > 1
        axes.scatter(
            [x for x, _ in points],
            [y for _, y in points],
            s=46 if series.wrong else 22 if many else 34,
            marker="x" if series.wrong else MARKERS[index % len(MARKERS)],
            facecolors=colour if series.wrong else ("none" if series.hollow else colour),
            edgecolors=None if series.wrong else colour,
            linewidths=1.8 if series.wrong else 1.1,
            alpha=0.75 if many and not series.wrong else 1.0,
            label=series.label,
            zorder=4 if series.wrong else 3,
        )
    axes.set_title(panel.title)
    axes.grid(axis="y", visible=False)
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)
    if panel.log:
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter("{x:g}")
        axes.minorticks_off()
    elif from_zero:
        axes.set_xlim(left=0.0)


def _curves(chart: CurveChart) -> "Figure":
    rows, columns = len(chart.rows), len(chart.rows[0])
    width = min(9.0, chart.sizes[0] * columns + 0.4)
    figure, grid = _new(width, chart.sizes[1] * rows + 0.7, rows, columns, sharey="row")
    handles: dict[str, Any] = {}
    for row, (panels, axes_of_row) in enumerate(zip(chart.rows, grid, strict=True)):
        for column, (panel, axes) in enumerate(zip(panels, axes_of_row, strict=True)):
            for curve in panel.curves:
                known = [(x, y) for x, y in zip(curve.x, curve.y, strict=True) if y is not None]
                (line,) = axes.plot(
                    [x for x, _ in known],
                    [y for _, y in known],
                    color=COLOURS[curve.colour % len(COLOURS)],
                    linestyle=DASHES[curve.dash % len(DASHES)],
                    marker=MARKERS[curve.colour % len(MARKERS)],
                    markersize=3.6,
                    linewidth=1.6,
                )
                handles.setdefault(curve.label, line)
            if panel.mark_x is not None:
                axes.axvline(panel.mark_x, color=SOFT, linewidth=0.8, zorder=1)
            if panel.log_x:
                axes.set_xscale("log")
                axes.xaxis.set_major_formatter("×{x:g}")
                axes.minorticks_off()
            axes.set_title(panel.title)
            if column == 0:
                axes.set_ylabel(panel.y_label)
            if row == rows - 1:
                axes.set_xlabel(panel.x_label)
        axes_of_row[0].set_ylim(bottom=0.0)  # only now: the row's panels share what they need above
    fitting = max(1, int(LEGEND_LETTERS / (6 + max(map(len, handles)))))
    figure.legend(
        handles.values(),
        handles.keys(),
        loc="outside lower center",
        ncols=-(-len(handles) // -(-len(handles) // fitting)),  # as many as fit, in rows of the same length
        title=chart.legend_title or None,
        handlelength=3.2,
    )
    return figure
