"""The study of emptying as a picture: one HTML file that needs nothing from elsewhere."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import plotly.graph_objects as go
from plotly.subplots import make_subplots

from workbench.studies.plots import COLOURS, write_plot


def draw_emptying(path: Path, found: Mapping[str, Any], title: str) -> None:
    """What was taken of each pile, and why the rest stayed.

    Args:
        path: HTML file.
        found: a `summary`.
        title: of the whole.

    Raises:
        FileError: the file cannot be written.
    """
    titles = ("Parts of each pile", "Parts left, by the reason that got furthest")
    figure = make_subplots(1, 2, subplot_titles=titles)
    scenes = found["scenes"]
    x = [f"seed {scene['seed']}" for scene in scenes]
    rows = (
        ("taken", [scene["taken"] for scene in scenes]),
        ("failed", [scene["failed_picks"] - scene["failed_by_kind"]["missed"] for scene in scenes]),
        ("knocked out", [scene["knocked_out"] for scene in scenes]),
        ("left", [len(scene["left"]) for scene in scenes]),
    )
    colours = (COLOURS[2], COLOURS[3], COLOURS[6], COLOURS[5])
    for (name, counts), colour in zip(rows, colours, strict=True):
        figure.add_trace(go.Bar(x=x, y=counts, name=name, marker={"color": colour}), 1, 1)
    reasons = found["left_by_reason"]
    bars = go.Bar(
        x=list(reasons.values()),
        y=list(reasons),
        orientation="h",
        showlegend=False,
        marker={"color": COLOURS[5]},
        customdata=[_hover_text(scenes, kind) for kind in reasons],
        hovertemplate="%{customdata}<extra></extra>",
    )
    figure.add_trace(bars, 1, 2)
    figure.update_layout(barmode="stack")
    write_plot(path, figure, title)


MOST_LISTED = 12
"""Parts that are named when the pointer is on a bar."""


def _hover_text(scenes: list[dict[str, Any]], kind: str) -> str:
    lines = [
        f"seed {scene['seed']}, {left['part']}: {left['nearest_fix'] or 'no small change takes it'}"
        for scene in scenes
        for left in scene["left"]
        if left["kind"] == kind
    ]
    more = len(lines) - MOST_LISTED
    return "<br>".join([*lines[:MOST_LISTED], *([f"and {more} more"] if more > 0 else [])])
