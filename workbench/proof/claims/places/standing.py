"""Whether a part that is let go of over a station stands there, and where it stands then."""

from collections.abc import Iterator
from itertools import product

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.geometry import Floats
from workbench.model.messages.message import Message
from workbench.model.messages.proofs import ProofText
from workbench.model.part import Part, Station
from workbench.model.plan import ArmPlan, Plan, Violation
from workbench.model.scan import Detection
from workbench.proof.claims.scene import still_of, turned_pieces
from workbench.proof.claims.stages import put_at
from workbench.proof.engine.robot import Tree
from workbench.proof.engine.shapes import gap_of

STEADY = np.deg2rad(10.0)
"""[rad] The tilt that a part has to bear before it falls over."""

DROP = 0.002
"""[m] So much more than the margin a part may fall when it is let go of."""

STANDS_WITHIN = 0.0005
"""[m] Points of a part that are no higher than this above its lowest one are what it stands on."""

RESTS_WITHIN = 0.001
"""[m] How far what a part stands on may be below it, or above."""

SUPPORT_DIRECTIONS = 180
"""In which the outermost of the points that a part stands on are taken."""

CLOSED = 0.02
"""A surface that encloses less of the box around it than this share is none that is closed."""


def standing_violations(
    cell: Cell, tree: Tree, plan: Plan, arm_plan: ArmPlan
) -> Iterator[Violation]:
    """Whether a part that an arm lets go of over the station it names stands there from then on.

    A part stands where it falls by little, straight down, onto something that the cell has.  The
    points that it stands on are on the station and around its centre of mass, as if it were all
    of one material.
    """

    def violation(problem: Message) -> Violation:
        return Violation(problem, arm_plan.arm, "place")

    found = plan.detections[arm_plan.detection]
    station = next((known for known in cell.stations if known.name == arm_plan.station), None)
    if station is None:
        yield violation(ProofText.NO_STATION(station=arm_plan.station))
        return
    if not found.roll_known:
        yield violation(ProofText.STATION_ROLL())
        return
    part = cell.part(found.part)
    T_station_put = cell.T_world_station(station).actInv(put_at(cell, tree, plan, arm_plan))
    points = part.mesh.points @ T_station_put.rotation.T + T_station_put.translation
    low = float(points[:, 2].min())
    if not -STANDS_WITHIN <= low <= cell.policy.margin + DROP:
        most = cell.policy.margin + DROP
        yield violation(ProofText.OFF_STATION(height=low, station=station.name, most=most))
        return
    stands_on = points[points[:, 2] <= low + STANDS_WITHIN, :2]
    if np.any(np.abs(stands_on) > station.size / 2):
        yield violation(ProofText.OVER_EDGE(station=station.name))
    centre = centre_of_mass(part)
    if centre is None:
        yield violation(ProofText.NO_WEIGHT())
        return
    middle = T_station_put.act(centre)
    tilt = np.arctan2(stands_within(stands_on, middle[:2]), middle[2] - low)
    if tilt < STEADY:
        tilt, least = max(0.0, float(tilt)), float(STEADY)
        yield violation(ProofText.FALLS_OVER(station=station.name, tilt=tilt, least=least))
    stands = _standing(cell, tree, plan, arm_plan, station)
    gap = min(
        gap_of(piece, (body.shape, body.T_joint_body), 10 * RESTS_WITHIN)
        for pieces, body in product(turned_pieces(part, stands), still_of(cell, plan.scene))
        for piece in pieces
    )
    if gap > RESTS_WITHIN:
        yield violation(ProofText.NOT_CARRIED(station=station.name))
    elif gap < -max(cell.policy.sink, STANDS_WITHIN):
        yield violation(ProofText.STANDS_IN(depth=-gap, station=station.name))


def standing_after(cell: Cell, tree: Tree, plan: Plan, arm_plan: ArmPlan) -> Detection:
    """A part that a proven plan puts on a station, where it stands afterwards.

    Where it was found stays with it: that it was moved is known, and by which way.
    """
    station = next(known for known in cell.stations if known.name == arm_plan.station)
    return _standing(cell, tree, plan, arm_plan, station)


def _standing(cell: Cell, tree: Tree, plan: Plan, arm_plan: ArmPlan, station: Station) -> Detection:
    found = plan.detections[arm_plan.detection]
    T_world_put = put_at(cell, tree, plan, arm_plan)
    T_world_station = cell.T_world_station(station)
    up = np.asarray(T_world_station.rotation[:, 2])
    points = cell.part(found.part).mesh.points @ T_world_put.rotation.T + T_world_put.translation
    low = float(((points - T_world_station.translation) @ up).min())
    T_world_part = pin.SE3(T_world_put.rotation, T_world_put.translation - low * up)
    was = found.T_world_part if found.T_world_found is None else found.T_world_found
    return Detection(found.part, T_world_part, found.score, T_world_found=was)


def centre_of_mass(part: Part) -> Floats | None:
    """The centre of mass (3,) [m] of a part of one material; None where its surface is open."""
    points = np.asarray(part.mesh.points)
    middle = points.mean(axis=0)
    a, b, c = (points[part.mesh.triangles[:, k]] - middle for k in range(3))
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    whole = float(volumes.sum())
    if abs(whole) < CLOSED * float(np.prod(np.ptp(points, axis=0))):
        return None
    return middle + (volumes[:, None] * (a + b + c) / 4.0).sum(axis=0) / whole


def stands_within(points: Floats, middle: Floats) -> float:
    """How far inside of points (n, 2) [m] another one (2,) is; 0 or less where it is outside.

    The outermost points of some directions stand for all, which can only make that less.
    """
    angles = np.arange(SUPPORT_DIRECTIONS) * (2 * np.pi / SUPPORT_DIRECTIONS)
    outward = np.column_stack([np.cos(angles), np.sin(angles)])
    rim = (points - middle)[np.unique((points @ outward.T).argmax(axis=0))]
    along = (rim[:, None] - rim[None]).reshape(-1, 2)
    lengths = np.linalg.norm(along, axis=1)
    along = along[lengths > 1e-6] / lengths[lengths > 1e-6, None]
    if len(along) == 0:
        return -np.inf
    # What is farthest inwards of an edge's own direction is the edge.
    across = np.column_stack([along[:, 1], -along[:, 0]])
    return float((rim @ across.T).max(axis=0).min())
