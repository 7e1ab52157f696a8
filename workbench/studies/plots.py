"""Plots of the studies, each one HTML file that needs nothing from elsewhere."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import plotly.graph_objects as go
from plotly.subplots import make_subplots

from workbench.model.errors import FileError
from workbench.studies.threshold import Case

COLOURS = ("#1c64b4", "#e8590c", "#287d38", "#ae3ec9", "#0b7285", "#868e96", "#c92a2a")

Rows = Sequence[Mapping[str, Any]]


def draw_planners(path: Path, ours: Rows, theirs: Rows) -> None:
    """Success, time, tool way and iterations used, against the iterations allowed.

    Raises:
        FileError: the file cannot be written.
    """
    titles = ("Success [%]", "Mean time [ms]", "Mean way of the tool [mm]", "Iterations used")
    figure = make_subplots(2, 2, subplot_titles=titles)
    keys = (("success", 100), ("mean", 1000), ("tool_way_mean", 1000), ("iterations_mean", 1))
    names = list(dict.fromkeys(row["planner"] for row in ours))
    for number, name in enumerate(names):
        rows = [row for row in ours if row["planner"] == name]
        for place, (key, factor) in enumerate(keys):
            figure.add_trace(
                go.Scatter(
                    x=[row["allowed"] for row in rows],
                    y=[None if row[key] is None else row[key] * factor for row in rows],
                    name=name,
                    legendgroup=name,
                    showlegend=place == 0,
                    line={"color": COLOURS[number % len(COLOURS)]},
                ),
                row=place // 2 + 1,
                col=place % 2 + 1,
            )
    for row in theirs:
        for place, (key, factor) in enumerate(keys[:3]):
            if row[key] is not None:
                figure.add_hline(
                    y=row[key] * factor,
                    line={"dash": "dot", "color": COLOURS[-1], "width": 1},
                    annotation_text=row["planner"],
                    row=place // 2 + 1,  # type: ignore[arg-type]
                    col=place % 2 + 1,  # type: ignore[arg-type]
                )
    figure.update_xaxes(type="log", title_text="iterations allowed")
    write_plot(path, figure, "Planners from one configuration to random tool poses in the bin")


def draw_threshold(path: Path, cases: Sequence[Case], rows: Rows) -> None:
    """What each threshold gives, and the planning time of every pile over its distance.

    Raises:
        FileError: the file cannot be written.
    """
    titles = ("Far enough apart [% of piles]", "Parts an hour", "Planning time of each pile [ms]")
    figure = make_subplots(1, 3, subplot_titles=titles)
    x = [row["threshold"] * 1000 for row in rows]
    shares = [None if (v := row["allowed_share"]) is None else 100 * v for row in rows]
    figure.add_trace(go.Scatter(x=x, y=shares, name="share", line={"color": COLOURS[0]}), 1, 1)
    hourly = [row["parts_per_hour"] for row in rows]
    figure.add_trace(go.Scatter(x=x, y=hourly, name="parts", line={"color": COLOURS[2]}), 1, 2)
    able = [case for case in cases if case.is_reachable]
    for number, name in enumerate(("alternated", "coordinated")):
        ways = [getattr(case, name) for case in able]
        figure.add_trace(
            go.Scatter(
                x=[case.distance * 1000 for case in able],
                y=[way.planning * 1000 for way in ways],
                mode="markers",
                name=name,
                marker={
                    "color": COLOURS[number],
                    "symbol": ["circle" if way.is_proven else "x" for way in ways],
                },
                text=[f"seed {case.seed}" for case in able],
            ),
            1,
            3,
        )
    figure.update_xaxes(title_text="threshold [mm]")
    figure.update_xaxes(title_text="distance of the parts [mm]", row=1, col=3)
    write_plot(path, figure, "Two parts at random: the distance from which both arms work at once")


def draw_localization(path: Path, rows: Rows, sure: Mapping[str, Any]) -> None:
    """What is right of the best two and of all, what is found, how long it takes, how sure it is.

    Raises:
        FileError: the file cannot be written.
    """
    error = sure["calibration_error"]
    titles = (
        "Right or found [%]",
        "Time of a search [ms]",
        "Share that is right [%] over the chance stated [%]"
        + ("" if error is None else f", {100 * error:.1f} apart"),
    )
    figure = make_subplots(3, 1, subplot_titles=titles, vertical_spacing=0.15)
    x = [f"{row['part']}<br>{row['count']} parts<br>{row['build']}" for row in rows]
    kinds = (("best_right", "best two right"), ("precision", "precision"), ("recall", "recall"))
    for number, (key, name) in enumerate(kinds):
        shares = [None if row[key] is None else 100 * row[key] for row in rows]
        figure.add_trace(
            go.Scatter(
                x=x,
                y=shares,
                name=name,
                mode="markers",
                marker={"size": 13, "symbol": number, "color": COLOURS[number]},
            ),
            1,
            1,
        )
    for number, (key, name) in enumerate((("median", "median time"), ("p90", "90 %"))):
        times = [None if row["seconds"] is None else 1000 * row["seconds"][key] for row in rows]
        colour = COLOURS[3 + number]
        figure.add_trace(go.Bar(x=x, y=times, name=name, marker={"color": colour}), 2, 1)
    figure.update_yaxes(rangemode="tozero", row=2, col=1)
    figure.add_trace(
        go.Scatter(
            x=[100 * probability_bin["stated"] for probability_bin in sure["bins"]],
            y=[100 * probability_bin["right"] for probability_bin in sure["bins"]],
            text=[f"{probability_bin['count']} detections" for probability_bin in sure["bins"]],
            name="chance",
            mode="markers",
            marker={"size": 13, "color": COLOURS[5]},
        ),
        3,
        1,
    )
    line = {"dash": "dot", "color": COLOURS[-1], "width": 1}
    figure.add_shape(type="line", x0=0, y0=0, x1=100, y1=100, line=line, row=3, col=1)  # type: ignore[arg-type]
    write_plot(path, figure, "Parts in seeded piles: how many are found, and found rightly")


def write_plot(path: Path, figure: go.Figure, title: str) -> None:
    """Write a figure with its title as one HTML file.

    Raises:
        FileError: the file cannot be written.
    """
    figure.update_layout(title=title, template="plotly_white", height=760)
    try:
        figure.write_html(path, include_plotlyjs=True)
    except OSError as error:
        raise FileError(path, error.strerror or "cannot be written") from None
