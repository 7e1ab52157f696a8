"""The plan over time: the lanes of the arms, and curves of joints and clearance."""

from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

from workbench.gui.shared.colours import JOINTS, arm_colour
from workbench.gui.shared.playback import (
    AGAIN,
    ON_STATION,
    OVER,
    Run,
    SyncPoint,
    arm_path,
    sync_points,
)
from workbench.gui.shared.plots import Curve, Plot
from workbench.gui.texts.labels import LabelText
from workbench.gui.texts.plan import PlanText
from workbench.model.cell import Arm, Cell
from workbench.model.derived.controller_axes import shown_axes, units_said
from workbench.model.geometry import Floats
from workbench.model.messages.message import Message, plain
from workbench.model.messages.plans import leg_message, motion_message
from workbench.model.plan import Proof
from workbench.proof.claims.stages import NEAR_MARGIN_LEGS
from workbench.words.words import IN_ENGLISH, Words

COLOUR_SHARES: Mapping[str, float] = {
    "reach": 0.4,
    "approach": 0.75,
    "extract": 1.0,
    "return": 0.55,
    "place": 0.85,
    ON_STATION: 1.0,
    AGAIN: 0.7,
    OVER: 0.7,
    "home": 0.25,
    "view": 0.4,
    "stir": 0.85,
    "stow": 0.75,
    "retract": 1.0,
    "cross": 0.55,
    "dock": 0.75,
    "undock": 1.0,
    "lift": 1.0,
    "carry": 0.55,
}
"""How much of the arm's colour a leg has, by its name on the page: legs that follow differ."""

INSTANT = 1e-6
"""Too short to see [s]: sets the two sides of a step apart."""

CURVE_POINTS = 240
"""Points of a curve over the whole plan."""


NAME_SPACING = 0.045
"""[of the whole time] Names of sync points that are nearer to each other would overlap."""


def lanes_html(cell: Cell, runs: tuple[Run, ...], seconds: float, words: Words = IN_ENGLISH) -> str:
    """A lane an arm, a block a leg, in proportion to the time; sync points across the lanes."""
    syncs = sync_points(runs)
    lanes = [_syncs(syncs, seconds, words)] if syncs else []
    lanes += _tracks(cell, runs, seconds, words)
    used = {run.words for run in runs}
    legend = "".join(_legend(cell, name) for name in COLOUR_SHARES if name in used)
    legend += '<span class="wb-leg"><i style="background:var(--wb-faint)"></i>waiting</span>'
    table = _sync_table(syncs, words) if syncs else ""
    return (
        f'<div class="wb-lanes" style="--wb-lanes:{len(cell.arms)}">{"".join(lanes)}'
        f'<div class="wb-legend">{legend}</div></div>{table}'
    )


def bands_html(cell: Cell, runs: tuple[Run, ...], seconds: float, words: Words = IN_ENGLISH) -> str:
    """The lanes alone, to lie under the slider of the time."""
    lanes = "".join(_tracks(cell, runs, seconds, words))
    return f'<div class="wb-bands"><div>{lanes}</div></div>'


def leg_colour(arm: int, leg: str) -> str:
    """The colour of a leg, by its name on the page, of the arm at that place in the cell."""
    share = COLOUR_SHARES[leg]
    channels = bytes.fromhex(arm_colour(arm)[1:])
    return "#" + "".join(f"{round(255 + (c - 255) * share):02x}" for c in channels)


def _legend(cell: Cell, leg: str) -> str:
    """The name of a leg, with its colour for each arm."""
    colours = [leg_colour(arm, leg) for arm in range(len(cell.arms))]
    swatches = "".join(f'<i style="background:{colour}"></i>' for colour in colours)
    return f'<span class="wb-leg">{swatches}{leg}</span>'


def _tracks(cell: Cell, runs: tuple[Run, ...], seconds: float, words: Words) -> list[str]:
    """A lane an arm, with its name."""
    return [
        '<div class="wb-lane"><span class="wb-lane-name" translate="no">'
        f"{escape(words.arm(arm.name))}</span>"
        f'<div class="wb-track">{_blocks(k, arm, runs, seconds, words)}<i class="wb-at"></i></div>'
        "</div>"
        for k, arm in enumerate(cell.arms)
    ]


def _blocks(number: int, arm: Arm, runs: tuple[Run, ...], seconds: float, words: Words) -> str:
    return "".join(_block(run, number, seconds, words) for run in runs if run.arm == arm.name)


def _syncs(syncs: tuple[SyncPoint, ...], seconds: float, words: Words) -> str:
    """Names of sync points above the lanes, each with a line down through them."""
    marks, last = "", -1.0
    for sync in syncs:
        at = sync.time / seconds
        name = sync.name if at - last >= NAME_SPACING else ""
        last = at if name else last
        before, after = _who(sync.before), _who(sync.after)
        tip = PlanText.SYNC_POINT(name=sync.name, time=sync.time, before=before, after=after)
        marks += (
            f'<i class="wb-sync" style="left:{100 * at:.3f}%" title="{escape(words.render(tip))}">'
            f"{name}</i>"
        )
    return (
        f'<div class="wb-lane wb-syncs"><span class="wb-lane-name"></span><div>{marks}</div></div>'
    )


def _who(runs: tuple[Run, ...]) -> Message:
    """The legs and their arms: `right: extract and left: home`."""
    return PlanText.LEGS(legs=map(_leg_of, runs))


def _leg_of(run: Run) -> Message:
    return PlanText.LEG_OF(arm=run.arm, leg=leg_of(run))


def leg_of(run: Run) -> Message:
    """What a leg is called on the page."""
    return plain(run.does) if run.does else leg_message(run.leg.name)


def _sync_table(syncs: tuple[SyncPoint, ...], words: Words) -> str:
    """Every sync point in a row, to be unfolded."""
    rows = "".join(
        f'<tr><td>{sync.name}</td><td class="wb-number">{sync.time:.2f} s</td>'
        f"<td>{escape(words.render(_who(sync.before)))}</td>"
        f"<td>{escape(words.render(_who(sync.after)))}</td></tr>"
        for sync in syncs
    )
    title = words.render(PlanText.SYNC_POINTS(count=len(syncs)))
    return (
        f'<details class="wb-folded"><summary>{escape(title)}</summary>'
        '<table class="wb-facts wb-plans"><thead><tr><th></th>'
        '<th class="wb-number">At</th><th>Once this has ended</th><th>this begins</th></tr></thead>'
        f"<tbody>{rows}</tbody></table></details>"
    )


def _block(run: Run, arm: int, seconds: float, words: Words) -> str:
    left, width = 100 * run.start / seconds, 100 * (run.end - run.start) / seconds
    block = PlanText.BLOCK_HELD if run.leg.holding else PlanText.BLOCK
    motion = motion_message(run.leg.motion)
    tip = words.render(block(leg=leg_of(run), start=run.start, end=run.end, motion=motion))
    holds = " wb-holds" if run.leg.holding else ""
    return (
        f'<div class="wb-block{holds}" title="{escape(tip)}" style="left:{left:.3f}%;'
        f'width:{width:.3f}%;background:{leg_colour(arm, run.words)}"></div>'
    )


def now_html(time: float, seconds: float, doing: Message | str, words: Words = IN_ENGLISH) -> str:
    """Where the scrubber stands, and what happens there."""
    return (
        f'<div class="wb-now"><b>{time:.2f} s</b> '
        f"{escape(words.render(PlanText.OF_SECONDS(total=seconds)))}"
        f"<span>{escape(words.render(doing))}</span></div>"
    )


def doing(runs: tuple[Run, ...], time: float) -> Message | str:
    """Which legs are under way at `time` [s]."""
    active = [_leg_of(run) for run in runs if run.start <= time < run.end]
    if active:
        return LabelText.LIST(items=active)
    return "at the end" if runs and time > 0 else "at home"


def axis_curves(cell: Cell, arm: Arm, runs: tuple[Run, ...], seconds: float) -> tuple[Floats, ...]:
    """Times (k,) [s] and where each axis is (k,) [deg, mm], as the controller counts it."""
    times = np.linspace(0.0, max(seconds, 1e-3), CURVE_POINTS)
    shown = [shown_axes(cell, arm, q) for q in arm_path(arm, runs, times)]
    return (times, *np.array(shown).T)


def clearance_curves(runs: tuple[Run, ...], proof: Proof) -> tuple[Floats, Floats, Floats, Floats]:
    """What nothing is nearer than over the time of a plan, from the bounds of its proof.

    Each bound holds from one waypoint to the next, so the curves go in steps; where several arms
    are on legs of one kind the smallest counts.

    Returns:
        Times (k,) [s]; the distance (k,) [mm] on free legs, on linear motions and between arms, NaN
        where there is no such leg.
    """
    kept = {(arm, leg): bounds for arm, leg, bounds in proof.clearances}
    apart = {(arm, leg): bounds for arm, leg, bounds in proof.apart}
    free = tuple(run for run in runs if run.leg.name not in NEAR_MARGIN_LEGS)
    straight = tuple(run for run in runs if run.leg.name in NEAR_MARGIN_LEGS)
    near, close, arms = (
        _spans(runs, *distances) for distances in ((free, kept), (straight, kept), (runs, apart))
    )
    changes = np.unique(np.concatenate([near[:, :2].ravel(), close[:, :2].ravel()]))
    if not len(changes):
        changes = np.array([0.0, 1.0])
    times = np.sort(np.concatenate([changes[:-1] + INSTANT, changes[1:] - INSTANT]))
    return times, _smallest(near, times), _smallest(close, times), _smallest(arms, times)


def _spans(
    runs: tuple[Run, ...], chosen: tuple[Run, ...], bounds: Mapping[tuple[str, str], Floats]
) -> Floats:
    """Start [s], end [s] and bound [mm] from each waypoint of some legs to the next, (k, 3).

    Where another leg of the same step takes longer, the last bound holds on: there the arm stands.
    """
    found: list[tuple[float, float, float]] = []
    for run in chosen:
        ends = run.start + np.asarray(run.leg.t[1:])
        ends[-1] = max(other.end for other in runs if other.start == run.start)
        starts, values = run.start + run.leg.t[:-1], bounds.get((run.arm, run.leg.name), ())
        found += zip(starts, ends, np.asarray(values)[: len(ends)] * 1000, strict=False)
    return np.array(found).reshape(-1, 3)


def _smallest(spans: Floats, times: Floats) -> Floats:
    """The smallest value of the spans that are under way at each time, NaN without one."""
    starts, ends, values = spans.T
    active = (starts <= times[:, None]) & (times[:, None] < ends)
    smallest = np.where(active, values, np.inf).min(axis=1, initial=np.inf)
    return np.where(np.isfinite(smallest), smallest, np.nan)


def speed_curve(arm: Arm, cell: Cell, runs: tuple[Run, ...], seconds: float) -> Floats:
    """How fast an arm's fastest joint turns, (SAMPLES,), in percent of its limit: no unit."""
    times = np.linspace(0.0, max(seconds, 1e-3), CURVE_POINTS)
    _, _, velocity = cell.robot.limits(arm.joints)
    speeds = np.abs(np.gradient(arm_path(arm, runs, times), times, axis=0)) / velocity
    return 100 * speeds.max(axis=1)


def plots_of(
    cell: Cell,
    runs: tuple[Run, ...],
    seconds: float,
    proofs: Sequence[Proof],
    words: Words = IN_ENGLISH,
) -> tuple[Plot, ...]:
    """The curves of a plan: what it keeps clear, how far apart arms are, speeds, and axes.

    `proofs` are those of the plans of a row, which `runs` are of; of none nothing is kept clear.
    """
    found: list[Plot] = []
    if proofs:
        each = [
            clearance_curves(tuple(run for run in runs if run.plan == place), proof)
            for place, proof in enumerate(proofs)
        ]
        times, free, straight, arms = (
            np.concatenate(columns) for columns in zip(*each, strict=True)
        )
        ways = (
            Curve("free motion", JOINTS[0], free),
            Curve("linear motion", JOINTS[5], straight),
        )
        policy = cell.policy
        required = ((policy.margin * 1000, JOINTS[0]), (policy.near_margin * 1000, JOINTS[5]))
        title = words.render(
            PlanText.CLEARANCES(margin=policy.margin, near_margin=policy.near_margin)
        )
        found.append(Plot(title, "mm", times, ways, low=0.0, limits=required))
        if len(cell.arms) > 1:
            apart = (Curve("between the arms", JOINTS[3], arms),)
            found.append(Plot("Least distance of the arms, up to 400", "mm", times, apart, low=0.0))
    speeds = tuple(
        Curve(words.arm(arm.name), arm_colour(k), speed_curve(arm, cell, runs, seconds))
        for k, arm in enumerate(cell.arms)
    )
    even = np.linspace(0.0, max(seconds, 1e-3), len(speeds[0].values))
    found.append(Plot("Fastest axis, of its limit", "%", even, speeds, low=0.0, high=100.0))
    for arm in cell.arms:
        times, *shown = axis_curves(cell, arm, runs, seconds)
        axes = (Curve(f"{k + 1}", JOINTS[k % len(JOINTS)], axis) for k, axis in enumerate(shown))
        title = words.render(PlanText.ARM_AXES(arm=arm.name))
        found.append(Plot(title, units_said(cell, arm), times, tuple(axes)))
    return tuple(found)
