"""A session as messages over time, for Foxglove and other readers of MCAP.

Scans, parts, plans, verdicts and the log stand at the time of their entry, and so do the joints
that the controller had reported.  `/tf` and `/planned_joints` show what a plan says: from when it
was made, and again from when it was sent.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import pinocchio as pin

from workbench.app.core.command import Entry
from workbench.app.core.cycle.sending import SendPlan
from workbench.app.core.state import Phase, State
from workbench.app.records.replay import replay
from workbench.app.records.session_archive import list_session
from workbench.app.records.sessions import cell_of
from workbench.extras.mcap import foxglove
from workbench.extras.mcap.writing import McapFile, mcap_file
from workbench.journal.journal import Journal
from workbench.model.cell import Cell
from workbench.model.errors import JournalError
from workbench.model.plan import Plan
from workbench.planning.collision.legs import stretches
from workbench.planning.kinematics.robot import Kinematics

STATE_EVERY = 0.05
"""[s] between two states of a motion; waypoints are added."""


def export_mcap(journal: Journal, path: Path) -> None:
    """Write a session into an MCAP file.

    Args:
        journal: of the session, which may go on meanwhile.
        path: of the file.

    Raises:
        JournalError: the journal cannot be read, or was changed after it was written.
        FileError: the file cannot be written.
    """
    if problems := journal.verify():
        raise JournalError(f"{journal.folder}: {problems[0]}; a changed session is not exported")
    cell = cell_of(journal)
    with mcap_file(path) as file:
        file.describe({key: str(value) for key, value in list_session(journal).head.items()})
        played = _Motion(file)
        last: State | None = None
        for entry, state in replay(journal, cell):
            if last is None:
                # Readers show nothing before the first frames.
                played.stand(entry.at, cell)
            elif state.cell is not last.cell:
                played.stand(entry.at, state.cell)
            _put(file, journal.folder.name, entry, last, state)
            is_new = state.plan is not None and (last is None or state.plan is not last.plan)
            if state.plan is not None and (is_new or isinstance(entry.command, SendPlan)):
                played.begin(entry.at, state.cell, state.plan)
            last = state
        played.end()


def _put(file: McapFile, session: str, entry: Entry, last: State | None, state: State) -> None:
    """What has come with one entry."""
    at = entry.at
    kind = type(entry.command).__name__
    level = foxglove.ERROR if state.phase is Phase.FAULT else foxglove.INFO
    says = f"{kind}: {state.message}"
    line = foxglove.log(at, level, entry.actor, says, session, entry.number)
    file.put("/log", "foxglove.Log", at, line)
    if entry.joints:
        file.put("/joints", "foxglove.JointStates", at, foxglove.joints(at, entry.joints))
    if state.scan is not None and (last is None or state.scan is not last.scan):
        file.put("/scan", "foxglove.PointCloud", at, foxglove.cloud(at, state.scan))
    if last is None or state.detections is not last.detections:
        poses = [detection.T_world_part for detection in state.detections or ()]
        file.put("/parts", "foxglove.PosesInFrame", at, foxglove.parts(at, poses))
    if state.verdict is not None and (last is None or state.verdict is not last.verdict):
        judged = foxglove.verdicts(at, state.verdict, state.candidates or ())
        file.put("/verdicts", "workbench.Verdicts", at, judged)
    if state.plan is not None and (last is None or state.plan is not last.plan):
        message = foxglove.plan_message(at, state.plan, state.proof)
        file.put("/plan", "workbench.Plan", at, message)


class _Motion:
    """Planned motions, each until the next one begins."""

    def __init__(self, file: McapFile) -> None:
        self._file = file
        self._cell: Cell | None = None
        self._kinematics: Kinematics | None = None
        self._waiting: tuple[float, Cell, Plan] | None = None

    def stand(self, at: float, cell: Cell) -> None:
        """The robot at home, in a cell that is another one from now on."""
        self.end(at)
        self._frames(at, cell, {})

    def begin(self, at: float, cell: Cell, plan: Plan) -> None:
        """A plan runs from now on [s since the epoch]."""
        self.end(at)
        self._waiting = at, cell, plan

    def end(self, until: float = np.inf) -> None:
        """Write the motion that has begun, as far as it gets."""
        if self._waiting is None:
            return
        start, cell, plan = self._waiting
        self._waiting = None
        for time, values in _play(cell, plan):
            at = start + time
            if at >= until:
                return
            message = foxglove.joints(at, values)
            self._file.put("/planned_joints", "foxglove.JointStates", at, message)
            self._frames(at, cell, values)

    def _frames(self, at: float, cell: Cell, values: Mapping[str, float]) -> None:
        if self._kinematics is None or self._cell is not cell:
            self._cell, self._kinematics = cell, Kinematics(cell)
        poses = self._kinematics.link_poses(values)
        message = foxglove.transforms(at, _tree(cell, poses))
        self._file.put("/tf", "foxglove.FrameTransforms", at, message)


def _tree(cell: Cell, poses: Mapping[str, pin.SE3]) -> Iterator[tuple[str, str, pin.SE3]]:
    """Parent, child and pose between them: the robot's links, and its root in the world."""
    yield foxglove.WORLD, cell.robot.root, poses[cell.robot.root]
    for joint in cell.robot.joints:
        yield joint.parent, joint.child, poses[joint.parent].actInv(poses[joint.child])


def _play(cell: Cell, plan: Plan) -> Iterator[tuple[float, dict[str, float]]]:
    """Times [s] from the plan's start, growing, and all joints of its arms [rad or m] then."""
    q = {arm.name: np.asarray(arm.home) for arm in cell.arms}
    q |= {arm.arm: np.asarray(arm.legs[0].q[0]) for arm in plan.arms}
    start = 0.0
    for stretch in stretches(plan):
        seconds = max(leg.seconds for _, leg in stretch.runs)
        waypoints = [leg.t for _, leg in stretch.runs]
        for t in np.unique(
            np.concatenate([np.arange(0.0, seconds, STATE_EVERY), *waypoints])
        ).tolist():
            q |= {arm.arm: leg.at(t) for arm, leg in stretch.runs}
            yield start + t, cell.joint_values(q)
        start += seconds
