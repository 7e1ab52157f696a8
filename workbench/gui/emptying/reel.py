"""A film of an emptied pile on one clock: where arms and parts are at each of its moments.

Arms move as planned, and what they hold moves with them.  Of how the rest settles only the ends are
known: in between the parts are shown on the straight way from how they lay to how they come to lie,
while the part is lifted.
"""

from bisect import bisect_right
from dataclasses import dataclass, replace
from itertools import accumulate

import numpy as np
import pinocchio as pin

from workbench.app.emptying.film import Film, FilmedPick, Shot
from workbench.gui.shared.look import FilmMoment, FilmPart
from workbench.gui.shared.own import Showing
from workbench.gui.shared.playback import Run, interpolate, moments, timeline
from workbench.gui.texts.emptying import EmptyingText
from workbench.gui.texts.labels import LabelText
from workbench.model.cell import Cell
from workbench.model.messages.message import FoundPart, Message, plain
from workbench.model.plan import LegName
from workbench.planning.kinematics.robot import Kinematics

LOOK_SHOWN_FOR = 0.5
"""[s] That a look into the bin is shown, before each plan and after the last."""

FAILED = {
    "missed": EmptyingText.MISSED,
    "crooked": EmptyingText.CROOKED,
    "turned": EmptyingText.TURNED,
    "slipped": EmptyingText.SLIPPED,
}
"""What an arm does whose pick fails, by the kind of failure."""


@dataclass(frozen=True, slots=True, eq=False)
class ReelStretch:
    """A shot on the film's clock: it begins at `start` [s] with a look, and `runs` after that."""

    shot: Shot
    runs: tuple[Run, ...]
    start: float
    end: float


@dataclass(frozen=True, slots=True, eq=False)
class Reel:
    """All shots of a film one after the other; `seconds` is how long it is."""

    film: Film
    stretches: tuple[ReelStretch, ...]
    seconds: float


def reel_of(film: Film) -> Reel:
    """A film laid on one clock."""
    runs = [timeline(shot.plan) for shot in film.shots]
    lengths = [
        LOOK_SHOWN_FOR + max((run.end for run in shot_runs), default=0.0) for shot_runs in runs
    ]
    ends = tuple(accumulate(lengths))
    stretches = tuple(
        ReelStretch(shot, shot_runs, end - length, end)
        for shot, shot_runs, length, end in zip(film.shots, runs, lengths, ends, strict=True)
    )
    return Reel(film, stretches, (ends[-1] if ends else 0.0) + LOOK_SHOWN_FOR)


class Projector:
    """Works out moments of films.

    Concurrency: one thread.
    """

    def __init__(self) -> None:
        self._reel: Reel | None = None
        self._kinematics: Kinematics | None = None
        self._cell: Cell | None = None

    def moment(self, cell: Cell, showing: Showing) -> FilmMoment:
        """How everything is at a moment of a film, in the cell in which it was made."""
        if self._kinematics is None or self._cell is not cell:
            self._cell, self._kinematics = cell, Kinematics(cell)
        if self._reel is None or self._reel.film is not showing.film:
            self._reel = reel_of(showing.film)
        return moment_of(cell, self._kinematics, self._reel, showing)


def moment_of(cell: Cell, kinematics: Kinematics, reel: Reel, showing: Showing) -> FilmMoment:
    """How everything is at the moment of a film that is viewed.

    Args:
        cell: in which it was made.
        kinematics: of that cell.
        reel: the film on its clock.
        showing: which moment, and why parts stay.
    """
    film, time = reel.film, showing.time
    number = bisect_right([known_stretch.start for known_stretch in reel.stretches], time) - 1
    if number < 0 or time >= reel.stretches[-1].end:
        left = tuple(
            FilmPart(k, detection.part, detection.T_world_part, showing.kinds.get(k, ""))
            for k, detection in film.left
        )
        return FilmMoment(moments(cell, (), 0.0), left, _end(film))
    stretch = reel.stretches[number]
    now = time - stretch.start - LOOK_SHOWN_FOR
    poses = _parts(cell, kinematics, stretch, now)
    kinds = dict(film.fallen)
    parts = tuple(FilmPart(k, kinds[k].part, T) for k, T in sorted(poses.items()))
    before = sum(
        pick.is_taken for earlier in reel.stretches[:number] for pick in earlier.shot.picks
    )
    return FilmMoment(
        moments(cell, stretch.runs, now), parts, _doing(film, stretch, now, before, number)
    )


def _parts(
    cell: Cell, kinematics: Kinematics, stretch: ReelStretch, now: float
) -> dict[int, pin.SE3]:
    """`T_world_part` of each part that is there `now` [s] on the plan's clock, by its number."""
    if stretch.shot.stirred:
        return _stirred(stretch, now)
    poses = {k: detection.T_world_part for k, detection in stretch.shot.before}
    for pick in stretch.shot.picks:
        lift = _run(stretch, pick, "extract")
        share = float(np.clip((now - lift.start) / max(lift.end - lift.start, 1e-9), 0.0, 1.0))
        if share <= 0.0:
            continue
        after = dict(pick.after)
        for k in tuple(poses):
            if k == pick.number:
                poses[k] = _pose_in_hand(cell, kinematics, stretch, pick, now)
            elif k in after:
                poses[k] = pin.SE3.Interpolate(poses[k], after[k].T_world_part, share)
            elif share >= 1.0 and not _was_taken(stretch, k):
                # It has fallen out of the bin.
                del poses[k]
    return poses


def _stirred(stretch: ReelStretch, now: float) -> dict[int, pin.SE3]:
    """`T_world_part` of each part `now` [s], between how they lie at two waypoints."""
    run, frames = _leg_run(stretch, "stir"), stretch.shot.stirred
    times = run.start + run.leg.t
    k = int(np.clip(np.searchsorted(times, now) - 1, 0, len(frames) - 2))
    share = float(np.clip((now - times[k]) / (times[k + 1] - times[k]), 0.0, 1.0))
    after = dict(frames[k + 1])
    return {
        number: pin.SE3.Interpolate(
            detection.T_world_part, after.get(number, detection).T_world_part, share
        )
        for number, detection in frames[k]
        if number in after or share < 1.0
    }


def _was_taken(stretch: ReelStretch, number: int) -> bool:
    return any(pick.number == number for pick in stretch.shot.picks)


def _run(stretch: ReelStretch, pick: FilmedPick, leg: LegName) -> Run:
    return _leg_run(stretch, leg, pick.arm)


def _leg_run(stretch: ReelStretch, leg: LegName, arm: str = "") -> Run:
    """A leg of an arm, of any where none is named."""
    return next(run for run in stretch.runs if arm in ("", run.arm) and run.leg.name == leg)


def _pose_in_hand(
    cell: Cell, kinematics: Kinematics, stretch: ReelStretch, pick: FilmedPick, now: float
) -> pin.SE3:
    """Where a part is that an arm has taken: in its hand, or where that has let go of it."""
    held = [
        run for run in stretch.runs if run.arm == pick.arm and run.leg.holding and run.start <= now
    ]
    run = held[-1] if held else _run(stretch, pick, "extract")
    q = interpolate(run.leg.q, run.leg.t, min(now, run.end) - run.start)
    return kinematics.tcp_pose(cell.arm(pick.arm), q) * pick.T_tcp_part


def _doing(film: Film, stretch: ReelStretch, now: float, taken: int, number: int) -> Message:
    """What goes on: which plan, how much is taken, and what the arms do."""
    lifted = [pick for pick in stretch.shot.picks if now >= _run(stretch, pick, "extract").end]
    taken += sum(pick.is_taken for pick in lifted)
    actions = [_does(pick) for pick in lifted] or [_goes_to(stretch.shot)]
    if now < 0.0:
        actions = [EmptyingText.SCANS()]
    return EmptyingText.FILM(
        number=number + 1,
        plans=len(film.shots),
        taken=taken,
        total=len(film.fallen),
        actions=LabelText.LIST(items=actions),
    )


def _goes_to(shot: Shot) -> Message:
    if shot.stirred:
        return EmptyingText.STIRS(arm=shot.plan.arms[0].arm)
    goes = (EmptyingText.GOES_TO(arm=pick.arm, part=_part(pick.number)) for pick in shot.picks)
    return EmptyingText.ARMS_GO(arms=goes)


def _does(pick: FilmedPick) -> Message:
    if not pick.outcome:
        return EmptyingText.HOLDS(arm=pick.arm, part=_part(pick.number))
    fails = FAILED.get(pick.outcome)
    if fails is None:
        return EmptyingText.FAILS(arm=pick.arm, why=plain(pick.outcome))
    return fails(arm=pick.arm)


def _part(number: int | None) -> FoundPart | Message:
    return EmptyingText.NO_PART() if number is None else FoundPart(number)


def _end(film: Film) -> Message:
    taken = sum(pick.is_taken for shot in film.shots for pick in shot.picks)
    total, left = len(film.fallen), len(film.left)
    if left:
        return EmptyingText.END_LEFT(taken=taken, total=total, left=left)
    return EmptyingText.END(taken=taken, total=total)


def end_of(reel: Reel) -> float:
    """Time [s] of the last plan's end; from then on the film lists the parts that stay."""
    return reel.stretches[-1].end if reel.stretches else 0.0


def advance(showing: Showing, elapsed: float) -> Showing:
    """A film so much later [s] by the clock on the wall, if it plays; it stops at its end."""
    if not showing.is_playing:
        return showing
    time = min(showing.time + elapsed * showing.speed, showing.seconds)
    return replace(showing, time=time, is_playing=time < showing.seconds)
