"""What is viewed: the part of the picture that no auditor asks for."""

import threading
from collections.abc import Callable, Mapping, Set
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pinocchio as pin

from workbench.app.core.state import Phase, State
from workbench.app.runtime.live import Live
from workbench.app.statistics.statistics import Statistics
from workbench.gui.shared.calibrating import Overlay
from workbench.gui.shared.own import NOTHING_OWN, Own, Visited
from workbench.gui.shared.playback import ArmMoment, Run, moments
from workbench.model.calibration import BinCheck, Calibration
from workbench.model.geometry import Floats, Shape
from workbench.model.messages.message import Message
from workbench.model.scan import RejectedHypothesis
from workbench.planning.collision.contact import Contact
from workbench.planning.picking.nearest_fix import Fix

HIDDEN_WITHIN = np.deg2rad(2.0)
"""Up to here a robot that is planned would only hide the real one [rad]."""

CLOCK = frozenset({"time", "is_playing"})
"""Fields of a look that say which moment of the plan is viewed."""

PLAYBACK = CLOCK | {"follows", "by", "browser", "speed", "loops"}
"""Fields of a look that playing a plan changes."""

AFTER_CYCLE = frozenset({Phase.DONE, Phase.FAULT})
"""Phases in which the plan has moved the robot, which does not stand at its start any more."""


CalibrationAnswer = Calibration | Message | str
"""Result from the scanned poses, or why there is none."""


@dataclass(frozen=True, slots=True, eq=False)
class DraggedThing:
    """What somebody drags: `name` is the person's, `browser` theirs, `T_world_held` where it is."""

    name: str
    browser: int
    T_world_held: pin.SE3


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """Which moment of the plan and which candidate everybody sees.

    `time` [s] on the plan's clock, which `follows` the robot until somebody plays the plan or drags
    through it, with nothing sent; `followed` [s] is how far it has followed the robot.  `candidate`
    is an index among the state's candidates, `pose` one among the poses of its way; `by` is the
    browser that moved the time last, None when nobody did (it plays); `browser` let it play, None:
    no browser did. It plays `speed` seconds of the plan in a second; `loops` says whether it begins
    again at its end.  `shapes` and `frames` say whether collision shapes and frames are shown,
    `reach` of which arm the reach is; `search` is a search whose parts are drawn beside those
    found, by its number, which the browser `searcher` has chosen; `rejected` says whether the poses
    that the last search rejected are shown, `scan_colours` whether a scan is in its own colours, if
    it has some; `held` is what somebody drags at this moment; `fixed` is the digest of the cell
    that the fix has made which was applied last; `scan_asked` is the number of parts and the seed
    of the scan that was asked for last, with which a browser that comes begins.
    """

    time: float = 0.0
    follows: bool = True
    followed: float = 0.0
    is_playing: bool = False
    candidate: int | None = None
    pose: int = 0
    by: int | None = None
    browser: int | None = None
    speed: float = 1.0
    loops: bool = False
    shapes: bool = False
    frames: bool = False
    reach: str = ""
    search: int | None = None
    searcher: int | None = None
    rejected: bool = False
    scan_colours: bool = False
    held: DraggedThing | None = None
    fixed: str = ""
    scan_asked: tuple[int, int] = (2, 0)

    @property
    def real_moment(self) -> Mapping[str, Any]:
        """Fields with which a preview ends: the moment of the plan that the robot has got to."""
        return {"time": self.followed, "is_playing": False, "follows": True, "by": None}


@dataclass(frozen=True, slots=True, eq=False)
class Help:
    """What would admit a refused candidate: `words` for people, and the `fix` if there is one."""

    words: Message | str = ""
    fix: Fix | None = None


NO_HELP = Help()

NOT_COUNTED = Statistics()

NO_REACH: tuple[Floats, Floats] = (np.zeros((0, 3)), np.zeros(0))
"""The reach that is shown where nobody has asked for one, and while it is worked out."""

UNKNOWN_REACH: tuple[Floats, Floats] = (np.zeros((0, 3)), np.zeros(0))
"""The reach that is shown where it could not be worked out."""

Placed = tuple[Shape, pin.SE3]


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """One arm standing somewhere on a candidate's way, or its hand alone.

    `q` (n,) [rad], None where no arm was asked: then the hand is at `T_world_tcp`; `opening` [m] of
    its fingers; `note` says whether it is clear there; `meets` are the two bodies that come too
    close, in the world, empty when none do.
    """

    label: Message | str
    q: Floats | None
    opening: float
    note: Message | str
    meets: tuple[Placed, ...] = ()
    T_world_tcp: pin.SE3 | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Jogged:
    """The robot moved by hand.

    `q`: arm -> configuration (n,) [rad]; `contacts` are the pairs nearer than their margins;
    `clearance` [m] is the least of all, between the bodies of `pair`, if it is small; `meets` are
    the bodies of the contacts in the world.
    """

    q: Mapping[str, Floats]
    contacts: tuple[Contact, ...]
    clearance: float
    pair: tuple[str, str] | None
    meets: tuple[Placed, ...]


@dataclass(frozen=True, slots=True, eq=False)
class FilmPart:
    """A part at a moment of a film: which one fell, of which kind, where, and why it stays.

    `kind` is empty while it is not reported that it stays.
    """

    number: int
    part: str
    T_world_part: pin.SE3
    kind: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class FilmMoment:
    """A moment of the film of an emptied pile.

    `arms` are the configurations of the arms by name, `parts` the parts in the bin and in hands;
    `says` describes what happens.
    """

    arms: Mapping[str, ArmMoment]
    parts: tuple[FilmPart, ...]
    says: Message


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """Everything that the page shows.

    Attributes:
        runs: timeline of the plan; empty without a plan.
        at: time of the view [s since the epoch].
        poses: poses of the chosen candidate.
        fix: changes that would make the chosen candidate feasible.
        help: without a plan: changes that would make some candidate feasible.
        reached: points of the shown workspace (n, 3) [m] and their shares (n,).
        calibration: result from the scanned poses, or why there is none.
        bin_check: what the scan shows of the cell's bin.
        is_recorded: whether this is a recorded session.
        sure: expected placing error of the chosen candidate's part.
        unseen: intervals of the plan [s] that the playing browser has not shown yet.
        hidden: those of them in which the hands were out of its view.
        own: look of one browser; this and what follows have defaults in the shared view.
        jogged: set while a person moves the robot by hand in this browser.
        overlay: pose of a calibration that is shown over the robot.
        filmed: moment of the film that is shown.
    """

    state: State
    live: Live
    look: Look
    runs: tuple[Run, ...]
    at: float
    poses: tuple[Pose, ...] = ()
    fix: Help = NO_HELP
    help: Help = NO_HELP
    reached: tuple[Floats, Floats] | None = None
    statistics: Statistics = NOT_COUNTED
    calibration: CalibrationAnswer = ""
    bin_check: BinCheck | None = None
    is_recorded: bool = False
    unseen: tuple[tuple[float, float], ...] = ()
    hidden: tuple[tuple[float, float], ...] = ()
    sure: Message | None = None
    own: Own = NOTHING_OWN
    jogged: Jogged | None = None
    overlay: Overlay | None = None
    filmed: FilmMoment | None = None

    @property
    def pose(self) -> Pose | None:
        """The pose of the chosen candidate that is viewed."""
        # The index comes from a browser's slider, and may be any number.
        last = len(self.poses) - 1
        return self.poses[min(max(self.look.pose, 0), last)] if self.poses else None

    @property
    def is_reported(self) -> bool:
        """Whether it is known where the robot stands: its controller reports every joint."""
        return self._has_all(self.live.joints)

    @property
    def was_reported(self) -> bool:
        """Whether its controller reports nothing now, but has reported where every joint was."""
        return not self.is_reported and self._has_all(self.live.last_joints)

    def _has_all(self, joints: Mapping[str, float]) -> bool:
        return all(joint in joints for arm in self.state.cell.arms for joint in arm.joints)

    @property
    def real(self) -> dict[str, ArmMoment]:
        """How every arm stands, by name: as reported, or as reported last, and else at home.

        What the fingers do nobody reports: while a plan is sent they are as planned.
        """
        cell = self.state.cell
        joints = self.live.last_joints if self.was_reported else self.live.joints
        found = moments(cell, (), 0.0)
        planned = moments(cell, self.runs, self.look.time) if self.look.follows else found
        for arm in cell.arms:
            if all(joint in joints for joint in arm.joints):
                q = np.array([joints[joint] for joint in arm.joints])
                found[arm.name] = replace(planned[arm.name], q=q)
        return found

    @property
    def is_previewed(self) -> bool:
        """Whether a moment of the plan is viewed that the robot has nothing to do with."""
        if self.state.plan is None or self.look.follows:
            return False
        return self.look.is_playing or self.look.time > 0 or self.state.phase in AFTER_CYCLE

    @property
    def planned_arms(self) -> frozenset[str]:
        """The arms that stand elsewhere as planned, or moved by hand, than they really do."""
        if self.own.hides_robot:
            # By hand a robot is moved by little, too.
            return self._elsewhere(0.0)
        is_placed = self.is_reported or self.was_reported
        if self.state.plan is None or not (is_placed or self.is_previewed):
            return frozenset()
        return self._elsewhere(HIDDEN_WITHIN)

    def _elsewhere(self, least: float) -> frozenset[str]:
        real, planned = self.real, self.moments
        return frozenset(
            arm for arm in planned if np.abs(real[arm].q - planned[arm].q).max() > least
        )

    @property
    def moments(self) -> dict[str, ArmMoment]:
        """How every arm is planned, by name: on its plan, jogged, as observed, or as filmed."""
        cell = self.state.cell
        now = moments(cell, self.runs, self.look.time)
        if self.jogged is not None:
            now |= {
                arm: ArmMoment(q, cell.arm(arm).tool.stroke[1], None)
                for arm, q in self.jogged.q.items()
            }
        if self.overlay is not None:
            now[self.overlay.arm] = ArmMoment(self.overlay.q, 0.0, None)
        if self.filmed is not None:
            now |= self.filmed.arms
        return now

    @property
    def visited(self) -> Visited | None:
        """The place of the plan that is viewed, as long as the plan stands there."""
        place = self.own.visited
        if place is None or place.time != self.look.time:
            return None
        return place if any(plan is place.plan for plan in self.state.plans) else None

    @property
    def rejected(self) -> tuple[RejectedHypothesis, ...]:
        """What the search rejected that brought the detections as they are now."""
        findings = self.live.findings
        if findings is None or findings.detections is not self.state.detections:
            return ()
        return findings.rejected

    @property
    def plan_seconds(self) -> float:
        """When the plan ends on its own clock."""
        return max((run.end for run in self.runs), default=0.0)


class SharedLook:
    """The look that all browsers share.

    Concurrency: any thread; `changed` is called after each change, outside the lock.
    """

    def __init__(self, changed: Callable[[], None]):
        """The start of the plan, no candidate."""
        self._now = Look()
        self._lock = threading.Lock()
        self._changed = changed

    @property
    def now(self) -> Look:
        """The newest look."""
        return self._now

    def change(self, **fields: Any) -> None:
        """Replace fields of the look.

        A moment of the plan takes the place of a candidate, and a candidate that of a preview.
        """
        with self._lock:
            if fields.keys() & CLOCK:
                fields = {"candidate": None, "follows": False, **fields}
                if fields["follows"] and "time" in fields:
                    fields["followed"] = fields["time"]
            elif fields.get("candidate") is not None and not self._now.follows:
                fields = {**self._now.real_moment, **fields}
            self._now = replace(self._now, **fields)
        self._changed()


class SteeredLook:
    """The shared look, for one person who may perhaps only follow it.

    Concurrency: as `SharedLook`.
    """

    def __init__(self, look: SharedLook, may: Callable[[Set[str]], bool]):
        """Follow a look.

        Args:
            look: that all browsers share.
            may: whether these fields may be changed by this person now.
        """
        self._look = look
        self._may = may

    @property
    def now(self) -> Look:
        """The newest look."""
        return self._look.now

    def change(self, **fields: Any) -> None:
        """Replace fields of the look, if the person may."""
        if self._may(fields.keys()):
            self._look.change(**fields)
