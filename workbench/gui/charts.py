"""The plan over time: the lanes of the arms, and curves of joints and clearance."""

from collections.abc import Mapping
from html import escape

import numpy as np
from viser import uplot

from workbench.gui.colours import BRAND, MUTED
from workbench.gui.playback import Run, arm_path
from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats
from workbench.model.plan import LegName, Proof

LEGS: Mapping[LegName, str] = {
    "reach": "#4dabf7",
    "approach": "#1c7ed6",
    "extract": "#f08c00",
    "return": "#ffa94d",
    "place": "#e8590c",
    "home": "#adb5bd",
}
"""Blue on the way to the part, orange with it, grey home."""

JOINTS = ("#1c7ed6", "#e8590c", "#2f9e44", "#ae3ec9", "#0ca678", "#f08c00", "#e64980", "#495057")

INSTANT = 1e-6
"""Too short to see [s]: sets the two sides of a step apart."""

SAMPLES = 240
"""Points of a curve over the whole plan."""


def lanes_html(cell: Cell, runs: tuple[Run, ...], seconds: float) -> str:
    """A lane an arm, a block a leg, in proportion to the time."""
    lanes: list[str] = []
    for arm in cell.arms:
        blocks = "".join(_block(run, seconds) for run in runs if run.arm == arm.name)
        lanes.append(
            f'<div class="wb-lane"><span class="wb-lane-name">{escape(arm.name)}</span>'
            f'<div class="wb-track">{blocks}</div></div>'
        )
    used = {run.leg.name for run in runs}
    legend = "".join(
        f'<span class="wb-leg"><i style="background:{colour}"></i>{name}</span>'
        for name, colour in LEGS.items()
        if name in used
    )
    return f'<div class="wb-lanes">{"".join(lanes)}<div class="wb-legend">{legend}</div></div>'


def _block(run: Run, seconds: float) -> str:
    left, width = 100 * run.start / seconds, 100 * (run.end - run.start) / seconds
    held = ", part in hand" if run.leg.holding else ""
    tip = f"{run.leg.name}: {run.start:.2f} s to {run.end:.2f} s, {run.leg.motion}{held}"
    return (
        f'<div class="wb-block" title="{escape(tip)}" style="left:{left:.3f}%;'
        f'width:{width:.3f}%;background:{LEGS[run.leg.name]}"></div>'
    )


def cursor_html(time: float, seconds: float, doing: str) -> str:
    """Where the scrubber stands in the lanes, and what happens there."""
    share = 0.0 if seconds <= 0 else 100 * min(max(time / seconds, 0.0), 1.0)
    return (
        f'<div class="wb-cursor"><div class="wb-cursor-track"><i style="left:{share:.2f}%"></i>'
        f'</div></div><div class="wb-now"><b>{time:.2f} s</b> of {seconds:.2f} s'
        f"<span>{escape(doing)}</span></div>"
    )


def doing(cell: Cell, runs: tuple[Run, ...], time: float) -> str:
    """Which legs are under way at `time` [s]."""
    active = [f"{run.arm} {run.leg.name}" for run in runs if run.start <= time < run.end]
    return ", ".join(active) or ("at the end" if runs and time > 0 else "at home")


def joint_curves(arm: Arm, runs: tuple[Run, ...], seconds: float) -> tuple[Floats, ...]:
    """Times [s] and the angle of each joint of an arm [deg], in the controller's order."""
    times = np.linspace(0.0, max(seconds, 1e-3), SAMPLES)
    wire = arm_path(arm, runs, times)[:, list(arm.wire_order)] * np.array(arm.wire_signs)
    return (times, *np.rad2deg(wire).T)


def clearance_curve(runs: tuple[Run, ...], proof: Proof) -> tuple[Floats, Floats]:
    """Times [s] and the clearance of what moves then [mm]; with both arms moving the smaller.

    Each value of the proof is the smallest distance on the way from one waypoint to the next,
    so the curve goes in steps.
    """
    found = {(arm, leg): distances for arm, leg, distances in proof.clearances}
    spans = [
        (run.start + start, run.start + end, distance * 1000)
        for run in runs
        for start, end, distance in zip(
            run.leg.t[:-1], run.leg.t[1:], found.get((run.arm, run.leg.name), ()), strict=False
        )
    ]
    if not spans:
        return np.array([0.0, 1.0]), np.zeros(2)
    starts, ends, distances = np.array(spans).T
    changes = np.unique(np.concatenate([starts, ends]))
    times = np.sort(np.concatenate([changes[:-1] + INSTANT, changes[1:] - INSTANT]))
    active = (starts <= times[:, None]) & (times[:, None] < ends)
    smallest = np.where(active, distances, np.inf).min(axis=1)
    covered = np.isfinite(smallest)
    return times[covered], smallest[covered]


def axis(label: str) -> uplot.Axis:
    """A uPlot axis with its unit."""
    return {
        "label": label,
        "labelSize": 18,
        "labelFont": "11px sans-serif",
        "font": "10px sans-serif",
        "stroke": MUTED,
        "size": 34,
        "grid": {"stroke": "#f1f3f5", "width": 1},
        "ticks": {"stroke": "#dee2e6", "width": 1, "size": 4},
    }


def curve(label: str, colour: str = BRAND) -> uplot.Series:
    """A uPlot series."""
    return {
        "label": label,
        "stroke": colour,
        "width": 1.5,
        "spanGaps": False,
        "points": {"show": False},
    }
