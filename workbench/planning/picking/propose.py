"""Every detection with every grasp and every arm, and the cheap tests that refuse most of them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from workbench.model.candidate import Candidate, Reason, Stage, Verdict
from workbench.model.cell import Arm, Cell
from workbench.model.part import Grasp
from workbench.model.scan import Detection, Obstacle
from workbench.planning.collision.legs import grips, openings
from workbench.planning.collision.tool_check import Hand, ToolCheck
from workbench.planning.kinematics.chain import chain_of

TURN_WEIGHT = 0.1
"""[m/rad] What a turn of the hand counts against its way in the SE(3) index."""


@dataclass(frozen=True, slots=True, eq=False)
class _Trial:
    """A candidate whose hand is still to be looked at."""

    detection: int
    grasp: Grasp
    arm: Arm
    T_world_tcp: pin.SE3


def propose(
    cell: Cell, detections: tuple[Detection, ...], obstacles: tuple[Obstacle, ...] = ()
) -> tuple[Candidate, ...]:
    """All candidates, refused ones included, in the order in which they shall be tried.

    The order: admitted ones first, then priority, then the SE(3) index, which is the way of
    the TCP from home to the grasp plus `TURN_WEIGHT` times its turn.
    """
    check = ToolCheck(cell, detections, obstacles)
    homes = {arm.name: chain_of(cell, arm).pose(np.asarray(arm.home)) for arm in cell.arms}
    trials = [
        _Trial(number, grasp, arm, detection.T_world_part * grasp.T_part_tcp)
        for number, detection in enumerate(detections)
        for grasp in cell.part(detection.part).grasps
        for arm in cell.arms
    ]
    return tuple(
        sorted(
            _candidates(cell, check, trials, homes),
            key=lambda c: (not c.verdict.is_ok, -c.grasp.priority, c.rank),
        )
    )


def candidate_of(
    cell: Cell,
    check: ToolCheck,
    number: int,
    detection: Detection,
    grasp: Grasp,
    arm: Arm,
    T_world_home: pin.SE3,
) -> Candidate:
    """One candidate with its first verdict; `T_world_home` is where the TCP is at home."""
    trial = _Trial(number, grasp, arm, detection.T_world_part * grasp.T_part_tcp)
    (candidate,) = _candidates(cell, check, [trial], {arm.name: T_world_home})
    return candidate


def _candidates(
    cell: Cell, check: ToolCheck, trials: Sequence[_Trial], homes: dict[str, pin.SE3]
) -> list[Candidate]:
    """The candidates of trials, in their order, with their first verdicts.

    A grasp whose fingers have to be less open than it says becomes one that says so.
    """
    verdicts = [_unfit(trial.grasp, trial.arm) for trial in trials]
    grasps = [trial.grasp for trial in trials]
    for arm in cell.arms:
        rows = [k for k, t in enumerate(trials) if t.arm is arm and verdicts[k] is None]
        _look(cell, check, arm, trials, rows, verdicts, grasps)
    found: list[Candidate] = []
    for trial, grasp, verdict in zip(trials, grasps, verdicts, strict=True):
        T_home_tcp = homes[trial.arm.name].actInv(trial.T_world_tcp)
        way = float(np.linalg.norm(T_home_tcp.translation))
        turn = float(np.linalg.norm(pin.log3(T_home_tcp.rotation)))
        found.append(
            Candidate(
                trial.detection,
                grasp,
                trial.arm.name,
                trial.T_world_tcp,
                way + TURN_WEIGHT * turn,
                verdict or Verdict(Reason.OK, Stage.PROPOSE),
            )
        )
    return found


def _unfit(grasp: Grasp, arm: Arm) -> Verdict | None:
    """Why an arm cannot use a grasp, whatever is around; None when it can."""
    if not grasp.is_enabled:
        return Verdict(Reason.DISABLED, Stage.PROPOSE)
    if grasp.arms and arm.name not in grasp.arms:
        return Verdict(Reason.ARM_NOT_ALLOWED, Stage.PROPOSE, note=f"only {', '.join(grasp.arms)}")
    if grasp.tool and grasp.tool != arm.tool.name:
        can = "can carry it" if grasp.tool in {one.name for one in arm.tools} else "cannot"
        note = f"is for {grasp.tool}; the arm carries {arm.tool.name} and {can}"
        return Verdict(Reason.ARM_NOT_ALLOWED, Stage.PROPOSE, note=note)
    low, high = arm.tool.stroke
    if arm.tool.fingers and not low <= grasp.opening <= high:
        return Verdict(
            Reason.TOOL_COLLISION,
            Stage.PROPOSE,
            note=f"opening {grasp.opening * 1e3:.0f} mm is outside the stroke "
            f"{low * 1e3:.0f}-{high * 1e3:.0f} mm",
        )
    return None


def _look(
    cell: Cell,
    check: ToolCheck,
    arm: Arm,
    trials: Sequence[_Trial],
    rows: list[int],
    verdicts: list[Verdict | None],
    grasps: list[Grasp],
) -> None:
    """Put the tool's verdicts into `verdicts`, and grasps with less open fingers into `grasps`.

    Each round looks at the next way of all hands for which none has worked yet: as the grasp says,
    turned as it leaves free, and the same with the fingers less open.  The verdict on a hand that
    fits in no way is that on the first one.
    """
    ways = {
        k: [
            (opening, number)
            for opening in openings(arm, trials[k].grasp, cell.policy.least_air)
            for number in range(len(grips(arm, trials[k].grasp)))
        ]
        for k in rows
    }
    refusals: dict[int, Verdict] = {}
    place = 0
    while rows:
        for k, verdict in zip(rows, _judged(check, arm, trials, rows, ways, place), strict=True):
            opening = ways[k][place][0]
            if verdict is not None:
                refusals.setdefault(k, verdict)
            else:
                refusals[k] = Verdict(Reason.OK, Stage.PROPOSE)
                if opening != grasps[k].opening and arm.tool.fingers:
                    grasps[k] = replace(grasps[k], opening=opening)
                ways[k] = []
        place += 1
        for k in rows:
            if len(ways[k]) <= place:
                verdicts[k] = refusals[k] if ways[k] else Verdict(Reason.OK, Stage.PROPOSE)
        rows = [k for k in rows if len(ways[k]) > place]


def _judged(
    check: ToolCheck,
    arm: Arm,
    trials: Sequence[_Trial],
    rows: Sequence[int],
    ways: dict[int, list[tuple[float, int]]],
    place: int,
) -> list[Verdict | None]:
    """What refuses each hand in its way of that place: fingers as on arrival, then as closed."""
    found: dict[int, Verdict] = {}
    for is_closed in (False, True) if arm.tool.fingers else (True,):
        left = [k for k in rows if k not in found]
        hands: list[Hand] = []
        for k in left:
            opening, number = ways[k][place]
            if not arm.tool.fingers:
                opening = 0.0
            elif is_closed:
                opening = trials[k].grasp.grip
            press = arm.tool.press if is_closed else 0.0
            hands.append(Hand(trials[k].detection, trials[k].grasp, number, opening, press))
        Ts = [
            trials[k].T_world_tcp * grips(arm, trials[k].grasp)[hand.grip]
            for k, hand in zip(left, hands, strict=True)
        ]
        for k, T, hand, pair in zip(left, Ts, hands, check.contacts(arm, Ts, hands), strict=True):
            if pair is None:
                continue
            found[k] = _REFUSED if place else _told(check, arm, T, hand.opening, pair)
    return [found.get(k) for k in rows]


_REFUSED = Verdict(Reason.TOOL_COLLISION, Stage.PROPOSE)
"""Of a way that is not the first: nobody is told."""


def _told(
    check: ToolCheck, arm: Arm, T_world_tcp: pin.SE3, opening: float, pair: tuple[int, int]
) -> Verdict:
    labels, distance = check.told(arm, T_world_tcp, opening, pair)
    note = f"fingers {opening * 1e3:.0f} mm apart" if arm.tool.fingers else ""
    return Verdict(Reason.TOOL_COLLISION, Stage.PROPOSE, labels, distance, note=note)
