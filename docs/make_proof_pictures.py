"""Makes the pictures of `docs/proof.md` from a plan for two parts, its proof, and bent plans.

`python docs/make_proof_pictures.py`; what is drawn is computed here, nothing is sketched.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from html import escape
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull

from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.proving import prove
from workbench.formats.cells.reading import read_cell
from workbench.formats.meshes.triangles import triangles_of
from workbench.gui.plan.curves import clearance_curves
from workbench.gui.shared.playback import Run, part_poses, timeline
from workbench.model.cell import Cell
from workbench.model.geometry import Floats, pose_from_rpy
from workbench.model.motion import MotionModel
from workbench.model.plan import Plan, Proof
from workbench.model.scan import Detection
from workbench.planning.kinematics.robot import Kinematics
from workbench.proof.claims import prove as layer
from workbench.proof.claims.motion import sweep_path
from workbench.proof.claims.scene import scene_bodies
from workbench.proof.claims.stages import NEAR_MARGIN_LEGS, find_carried, situation_of, steps_of
from workbench.proof.claims.table import PairTable
from workbench.proof.claims.timing.fastest import fastest
from workbench.proof.claims.timing.pace import marks_of
from workbench.proof.engine.robot import tree_of
from workbench.proof.engine.space import Space

PICTURES = Path(__file__).with_name("pictures")
WIDTH, HEIGHT, LEFT, BOTTOM = 560.0, 210.0, 46.0, 34.0

STYLE = """
svg { --ink: #33404d; --soft: #8896a5; --paper: #ffffff; --good: #1c64b4; --fill: #d6e6f7;
  --bad: #c92a2a; --warm: #d9480f }
@media (prefers-color-scheme: dark) { svg { --ink: #dfe5ea; --soft: #8896a5; --paper: #1d2126;
  --good: #6aaefc; --fill: #2b4766; --bad: #ff8787; --warm: #ffc078 } }
text { font: 12px system-ui, "DejaVu Sans", sans-serif; fill: var(--ink) }
.soft { fill: var(--soft) } .bad { fill: var(--bad) } .good { fill: var(--good) }
.warm { fill: var(--warm) }
path { fill: none; stroke: var(--soft); stroke-width: 1.2 }
path.good { fill: none; stroke: var(--good); stroke-width: 2 }
path.bad { fill: none; stroke: var(--bad); stroke-width: 2 }
path.thin { stroke-width: 0.5; opacity: 0.6 }
path.dashed { stroke-dasharray: 5 4 }
path.warm { fill: none; stroke: var(--warm); stroke-width: 2 }
path.area { fill: var(--fill); stroke: var(--good); stroke-width: 0.8 }
"""


class Sketch:
    """One picture: values in, SVG out; `x` and `y` are the ranges shown."""

    def __init__(
        self, title: str, x: Sequence[float], y: Sequence[float], *, same: bool = False
    ) -> None:
        self._title = title
        self._parts: list[str] = []
        wide, high = WIDTH - LEFT - 16, HEIGHT - BOTTOM - 16
        per_x, per_y = wide / (x[1] - x[0]), high / (y[1] - y[0])
        if same:
            per_x = per_y = min(per_x, per_y)
        self._low, self._per = (x[0], y[0]), (per_x, per_y)

    def _x(self, v: float) -> float:
        return LEFT + (v - self._low[0]) * self._per[0]

    def _y(self, v: float) -> float:
        return HEIGHT - BOTTOM - (v - self._low[1]) * self._per[1]

    def way(self, points: Floats, kind: str = "", *, closed: bool = False) -> None:
        """A line through points (n, 2)."""
        at = " L ".join(f"{self._x(a):.1f} {self._y(b):.1f}" for a, b in points)
        self._parts.append(f'<path class="{kind}" d="M {at}{" Z" if closed else ""}"/>')

    def hull(self, points: Floats, kind: str = "") -> None:
        """The outline of points (n, 2)."""
        self.way(points[ConvexHull(points).vertices], kind, closed=True)

    def say(self, x: float, y: float, text: str, kind: str = "") -> None:
        """A text that begins at a place."""
        at = f'x="{self._x(x):.1f}" y="{self._y(y):.1f}"'
        self._parts.append(f'<text class="{kind}" {at}>{escape(text)}</text>')

    def note(self, row: int, text: str, kind: str = "", x: float = LEFT) -> None:
        """A text in one of the rows from the top."""
        at = f'x="{x:.1f}" y="{16 + 16 * row}"'
        self._parts.append(f'<text class="{kind}" {at}>{escape(text)}</text>')

    def axes(self, x: Sequence[float], y: Sequence[float], says: str) -> None:
        """Marks on both axes, and what they are in."""
        for v in x:
            at = f'x="{self._x(v):.1f}" y="{HEIGHT - BOTTOM + 16}" text-anchor="middle"'
            self._parts.append(f'<text class="soft" {at}>{v:g}</text>')
        for v in y:
            at = f'x="{LEFT - 6}" y="{self._y(v) + 4:.1f}" text-anchor="end"'
            self._parts.append(f'<text class="soft" {at}>{v:g}</text>')
            self.way(np.array([[x[0], v], [x[-1], v]]), "thin")
        at = f'x="{WIDTH - 16}" y="{HEIGHT - 4}" text-anchor="end"'
        self._parts.append(f'<text class="soft" {at}>{escape(says)}</text>')

    def write(self, name: str) -> None:
        """Into the folder of pictures."""
        size = f'viewBox="0 0 {WIDTH:g} {HEIGHT:g}" width="{WIDTH:g}" height="{HEIGHT:g}"'
        lines = [
            f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img">',
            f"<title>{escape(self._title)}</title>",
            f"<style>{STYLE}</style>",
            f'<rect width="{WIDTH:g}" height="{HEIGHT:g}" fill="var(--paper)"/>',
            *self._parts,
            "</svg>",
        ]
        (PICTURES / f"proof_{name}.svg").write_text("\n".join(lines) + "\n", encoding="utf-8")


def two_parts(cell: Cell) -> tuple[Detection, ...]:
    """Two cylinders on the floor of the bin."""
    floor = cell.bin.T_world_bin.translation
    places = ((-0.01, -0.07, 0.4), (0.01, 0.07, -0.6))
    return tuple(
        Detection(
            "keyed_cylinder",
            pose_from_rpy(floor + np.array([x, y, 0.0191]), (np.pi / 2, 0.0, yaw)),
            0.9,
        )
        for x, y, yaw in places
    )


def scene(cell: Cell, plan: Plan, proof: Proof) -> None:
    """From above: the plan leaves out a part that is known."""
    less = replace(plan, detections=plan.detections[:1], arms=plan.arms[:1], sequence=())
    number = plan.arms[0].detection
    arm = replace(plan.arms[0], detection=0)
    steps = tuple(s for s in plan.sequence if all(a == arm.arm for a, _ in s.runs))
    less = replace(less, detections=(plan.detections[number],), arms=(arm,), sequence=steps)
    said = str(layer.prove(cell, plan.scene, less).violations[0])
    length, width, _ = cell.bin.size
    sketch = Sketch("A part that the plan leaves out", (-0.42, 0.42), (-0.135, 0.135), same=True)
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * (width / 2, length / 2)
    sketch.way(corners, closed=True)
    T_bin_world = cell.bin.T_world_bin.inverse()
    for k, one in enumerate(plan.detections):
        T = T_bin_world * one.T_world_part
        points = cell.part(one.part).mesh.points @ T.rotation.T + T.translation
        sketch.hull(points[:, 1::-1], "area" if k == number else "bad dashed")
        at = T.translation
        is_in = k == number
        words = f"part-{k + 1}, in the plan" if is_in else f"part-{k + 1}, known"
        sketch.say(0.18 if at[1] > 0 else -0.36, at[0], words, "good" if is_in else "bad")
    sketch.note(0, f"{said}", "bad")
    sketch.write("scene")


def controller(cell: Cell, plan: Plan, proof: Proof) -> None:
    """Two joints of a leg: its segments, and what a blending controller may make of its corners."""
    corners = [
        (leg, np.rad2deg(np.asarray(leg.q)[k : k + 3, a : a + 2]))
        for arm in plan.arms
        for leg in arm.legs
        for k in range(len(leg.q) - 2)
        for a in range(len(arm.joints) - 1)
    ]
    leg, path = max(corners, key=lambda one: _area(one[1]))
    corner = path[1]
    close = corner + 0.3 * (path - corner)
    low, high = close.min(axis=0), close.max(axis=0)
    room = 0.1 * (high - low)
    x, y = zip(low - room, high + room, strict=True)
    sketch = Sketch("What a controller may make of waypoints", x, y)
    sets = sweep_path(np.arange(2), path, MotionModel("any", corners="blend"), 0.2)
    for triangle in sets.corners[sets.sizes == 3]:
        sketch.way(triangle, "area", closed=True)
    sketch.way(close, "warm")
    sketch.axes(_marks(*x), _marks(*y), "two neighbouring joints [deg]")
    sketch.note(0, f"a corner of leg {leg.name}: the polyline,", "warm")
    sketch.note(0, "and all between it and blends of 20 %", "good", LEFT + 230)
    sketch.write("controller")


def fingers(cell: Cell, plan: Plan, proof: Proof) -> None:
    """The hand at a part, from its side: fingers open, closed, and all between."""
    one = plan.arms[0]
    arm, tree = cell.arm(one.arm), tree_of(cell)
    bodies = scene_bodies(cell, tree, plan.scene)
    space = Space(tree, bodies, PairTable(cell, tree, bodies))
    step = next(s for s in steps_of(cell, tree, plan) if s.moving[0].leg.name == "approach")
    leg, after = step.moving[0].leg, step.moving[0].fingers_after
    sketch = Sketch("Fingers on their way", (-0.13, 0.13), (-0.02, 0.075), same=True)
    q = step.base.copy()
    for share, kind in ((0.0, "good"), (0.5, "dashed"), (1.0, "warm")):
        opening = leg.opening + share * (after - leg.opening)
        q[tree.columns[arm.name]] = np.append(leg.q[-1], np.full(2, opening / 2))
        space.look(q)
        T_tcp = Kinematics(cell).tcp_pose(arm, np.asarray(leg.q[-1]))
        for number, body in enumerate(bodies):
            is_part = body.part == one.detection and share == 0.0
            if (body.arm == arm.name and body.kind == "tool" and body.is_finger) or is_part:
                points = np.asarray(triangles_of(body.shape).vertices)
                T = T_tcp.actInv(space.pose(number))
                points = points @ T.rotation.T + T.translation
                sketch.hull(
                    np.stack([points[:, 1], -points[:, 2]], axis=1), "area" if is_part else kind
                )
    sketch.note(0, f"open by {leg.opening * 1e3:.0f} mm", "good")
    sketch.note(1, f"at the part, {after * 1e3:.0f} mm", "warm")
    sketch.note(2, "and everywhere between; touching what is taken is meant", "soft")
    sketch.say(0.025, -0.012, f"part-{one.detection + 1}", "good")
    sketch.write("fingers")


def life(cell: Cell, plan: Plan, proof: Proof) -> None:
    """How high a part is over time, and what is asked of it."""
    runs, one = timeline(plan), plan.arms[0]
    mine = {run.leg.name: run for run in runs if run.arm == one.arm}
    end = mine["home"].end
    kinematics = Kinematics(cell)

    def heights(start: float, stop: float) -> Floats:
        times = np.linspace(start, stop, 60)
        poses = [part_poses(cell, kinematics, (plan,), runs, t)[one.detection] for t in times]
        return np.stack([times, [1e3 * T.translation[2] for T in poses]], axis=1)

    lift = heights(mine["extract"].start, mine["extract"].end)
    off = lift[0, 0] + (lift[-1, 0] - lift[0, 0]) * float(
        np.interp(10.0, lift[:, 1] - lift[0, 1], np.linspace(0, 1, len(lift)))
    )
    pieces = (
        (0.0, lift[0, 0], "good", f"lies, at most {cell.policy.sink * 1e3:g} mm deep"),
        (lift[0, 0], off, "bad", f"comes off: {cell.policy.release * 1e3:g} mm"),
        (off, mine["place"].end, "warm", "in the hand: margins of the cell"),
        (mine["place"].end, end, "good", "put down: an obstacle from now on"),
    )
    whole = np.concatenate([heights(a, b) for a, b, *_ in pieces])
    top = float(whole[:, 1].max())
    sketch = Sketch("The life of a part", (0.0, end), (0.0, 1.35 * top))
    sketch.axes(range(int(end) + 1), _marks(0.0, top), "height of the part [mm] over time [s]")
    for row, (start, stop, kind, says) in enumerate(pieces):
        sketch.way(heights(start, stop), kind)
        sketch.note(row // 2, says, kind, LEFT + 250 * (row % 2))
    sketch.write("life")


def asked(cell: Cell, plan: Plan, proof: Proof) -> None:
    """How fast joints turn between waypoints, as planned, and with times shortened by somebody."""
    one = plan.arms[0]
    run = next(run for run in timeline(plan) if run.arm == one.arm)
    quick = replace(run.leg, t=0.42 * np.asarray(run.leg.t))
    legs = tuple(quick if leg is run.leg else leg for leg in one.legs)
    arms = tuple(replace(a, legs=legs) if a is one else a for a in plan.arms)
    said = str(prove(cell, replace(plan, arms=arms)).violations[0])
    share = cell.policy.speed
    sketch = Sketch("Joint speeds", (0.0, run.leg.seconds), (0.0, 145.0))
    sketch.axes(_marks(0.0, run.leg.seconds), (0, 50, 100), "fastest axis [%] over time [s]")
    velocity = cell.robot.limits(cell.arm(one.arm).joints)[2]
    for leg, kind in ((run.leg, "good"), (quick, "bad")):
        speeds = np.abs(np.diff(leg.q, axis=0)) / np.diff(leg.t)[:, None] / velocity
        fastest = 100 * speeds.max(axis=1)
        steps = np.stack([np.repeat(leg.t, 2)[1:-1], np.repeat(fastest, 2)], axis=1)
        sketch.way(steps, kind)
    sketch.way(np.array([[0.0, 100 * share], [run.leg.seconds, 100 * share]]), "warm dashed")
    sketch.note(0, f"as planned; the cell allows {share:.0%}", "good")
    sketch.note(1, said, "bad")
    sketch.write("asked")


def bounds(cell: Cell, plan: Plan, proof: Proof) -> None:
    """The bounds of the free legs, and what dense samples show."""
    runs = timeline(plan)
    times, free, _, _ = clearance_curves(runs, proof)
    top = 2.0 * float(np.nanmax(free))
    sketch = Sketch("Clearances are bounds", (0.0, times[-1]), (0.0, top))
    marks = range(0, int(times[-1]) + 1, 2)
    sketch.axes(marks, _marks(0.0, 0.8 * top), "kept on free legs [mm] over time [s]")
    for stretch in _whole(np.stack([times, free], axis=1)):
        sketch.way(stretch, "good")
    for stretch in _sampled(cell, plan, runs, 0.75 * top):
        sketch.way(stretch, "warm")
    sketch.note(0, f"what the proof tells: {proof.clearance * 1e3:.1f} mm or more", "good")
    sketch.note(0, "measured, at every 40th of a segment", "warm", LEFT + 260)
    sketch.write("bounds")


def pace(cell: Cell, plan: Plan, proof: Proof) -> None:
    """The fastest motion along a leg, which touches limits, and who asks for more."""
    arm, leg = cell.arm(plan.arms[0].arm), plan.arms[0].leg("place")
    slopes, widths = marks_of(np.diff(leg.q, axis=0), cell.zone)
    velocity = cell.robot.limits(arm.joints)[2] * cell.policy.speed
    x = fastest(slopes, widths, velocity, arm.acceleration)
    times = np.append(0.0, np.cumsum(2 * widths / (np.sqrt(x[:-1]) + np.sqrt(x[1:]))))
    speeds = 100 * (np.abs(slopes) / velocity).max(axis=1) * np.sqrt(x)
    rise, bend = (np.diff(a, axis=0) / widths[:, None] for a in (x[:, None], slopes))
    ends = [
        k * rise / 2 + bend * v[:, None] for k, v in ((slopes[:-1], x[:-1]), (slopes[1:], x[1:]))
    ]
    pushes = 100 * np.abs(np.stack(ends, axis=1) / arm.acceleration).max(axis=2).ravel()
    both = np.repeat(times, 2)[1:-1]
    quick = replace(leg, t=0.98 * times[-1] / leg.seconds * np.asarray(leg.t))
    legs = tuple(quick if one is leg else one for one in plan.arms[0].legs)
    said = prove(cell, replace(plan, arms=(replace(plan.arms[0], legs=legs), *plan.arms[1:])))
    sketch = Sketch("The fastest motion along a leg", (0.0, leg.seconds), (0.0, 150.0))
    sketch.axes(
        _marks(0.0, leg.seconds), (0, 50, 100), "share of what is allowed [%] over time [s]"
    )
    for passed in times[:: len(widths) // (len(leg.q) - 1)]:
        sketch.way(np.array([[passed, 0.0], [passed, 100.0]]), "thin")
    sketch.way(np.stack([both, pushes], axis=1), "warm")
    sketch.way(np.stack([times, speeds], axis=1), "good")
    sketch.note(0, "speed of the joint that is nearest to its limit", "good")
    sketch.note(1, "acceleration of the joint that is nearest to its limit", "warm")
    sketch.note(0, f"takes {times[-1]:.2f} s, the plan {leg.seconds:.2f} s", "", LEFT + 330)
    sketch.note(2, f"in 0.98 of that: {said.violations[0].problem}", "bad")
    sketch.write("pace")


def _sampled(cell: Cell, plan: Plan, runs: tuple[Run, ...], most: float) -> list[Floats]:
    """Distances of what moves from all else, up to `most` [mm], on free legs: (n, 2) [s, mm]."""
    tree = tree_of(cell)
    bodies = scene_bodies(cell, tree, plan.scene)
    table = PairTable(cell, tree, bodies)
    space = Space(tree, bodies, table)
    found: list[Floats] = []
    for step in steps_of(cell, tree, plan):
        if any(one.leg.name in NEAR_MARGIN_LEGS for one in step.moving):
            continue
        places = [part.T_world_part for part in plan.detections]
        space.put_parts(places, find_carried(cell, tree, plan, step))
        pairs = table.pairs(situation_of(tree, step, *step.moving), space.joints)
        rows = pairs.rows[pairs.shown & ~pairs.left]
        named = {(one.arm.name, one.leg) for one in step.moving}
        start = next(run.start for run in runs if (run.arm, run.leg) in named)
        line: list[tuple[float, float]] = []
        segments = sum(len(one.path) - 1 for one in step.moving)
        for t in np.linspace(0.0, max(one.leg.seconds for one in step.moving), 40 * segments):
            q = step.base.copy()
            for one in step.moving:
                values = [np.interp(t, one.leg.t, column) for column in one.path.T]
                q[tree.columns[one.arm.name]] = values
            space.look(q)
            nearest = min(space.distance(int(row)) for row in rows)
            line.append((start + t, 1e3 * nearest if 1e3 * nearest < most else np.nan))
        found += _whole(np.array(line))
    return found


def _whole(points: Floats) -> list[Floats]:
    """Stretches without gaps."""
    gaps = np.flatnonzero(np.isnan(points[:, 1]))
    return [part[~np.isnan(part[:, 1])] for part in np.split(points, gaps) if len(part) > 2]


def _area(corner: Floats) -> float:
    """Of the triangle of three points (3, 2)."""
    first, second = corner[1] - corner[0], corner[2] - corner[1]
    return abs(float(first[0] * second[1] - first[1] * second[0]))


def _marks(low: float, high: float) -> list[float]:
    """Round numbers between two."""
    step = 10 ** np.floor(np.log10(high - low)) / 2
    step *= 1 if (high - low) / step <= 6 else 4 if (high - low) / step > 12 else 2
    first, last = int(np.ceil(low / step)), int(np.floor(high / step))
    return [float(step * k) for k in range(first, last + 1)]


DRAWN: tuple[Callable[[Cell, Plan, Proof], None], ...] = (
    scene,
    controller,
    fingers,
    life,
    asked,
    pace,
    bounds,
)


def main() -> None:
    """Plan, prove, draw."""
    cell = read_cell("yumi")
    result = plan_pick(cell, two_parts(cell), "drawn", seed=0)
    if result.plan is None or result.proof is None:
        raise SystemExit(f"no plan to draw: {result.verdict}")
    for draw in DRAWN:
        draw(cell, result.plan, result.proof)


if __name__ == "__main__":
    main()
