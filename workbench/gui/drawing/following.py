"""What is viewed belongs to a state: the moment of the plan, and parts of searches beside it."""

from workbench.app.core.state import Phase, State
from workbench.app.runtime.live import Live
from workbench.gui.shared.look import AFTER_CYCLE, SharedLook
from workbench.gui.shared.playback import Run, follow_plan

SENT = AFTER_CYCLE | {Phase.SENDING}
"""The plan has moved the robot, or does."""

LET_OUT = frozenset({Phase.APPROVED, Phase.SENDING})
"""Phases that are nothing but what becomes of a plan."""


def keep_up(
    look: SharedLook, before: State | None, state: State, live: Live, runs: tuple[Run, ...]
) -> None:
    """Have all see what a state has come to.

    Args:
        look: is changed where it does not belong to the state.
        before: the state that was viewed before, None when there was none.
        state: that is seen from now on.
        live: where the robot is reported to be.
        runs: the timeline of the state's plan, or of its row.
    """
    if before is not None and _is_other_scene(before, state):
        look.change(time=0.0, is_playing=False, candidate=None, pose=0, by=None, follows=True)
    if before is not None and (look.now.search is not None or look.now.rejected):
        _end_comparing(look, before, state)
    if state.phase is Phase.SENDING:
        at = look.now.followed
        if live.joints:
            at = follow_plan(state.cell, runs, live.joints, at)
        # A hand on the scrubber that came a moment too late would hold the picture for good.
        if at != look.now.time or not look.now.follows:
            look.change(time=at, is_playing=False, by=None, follows=True)
    was_done = before is not None and before.phase is Phase.DONE and before.plans == state.plans
    if state.phase is Phase.DONE and not was_done:
        # The last reports of a quick robot may never have been drawn, those of a cycle that was
        # done before this page began never were.
        end = max((run.end for run in runs), default=0.0)
        look.change(time=end, is_playing=False, by=None, follows=True)


def _planning(state: State) -> int:
    """The number of the planning that is under way; 0: none is."""
    return state.job.number if state.job is not None and state.job.name == "plan" else 0


def _end_comparing(look: SharedLook, before: State, state: State) -> None:
    """What a search found besides, or rejected, goes where a plan is asked for or let out.

    Nobody must take it for what lies in the bin.
    """
    is_planned = before.plans != state.plans or _planning(before) < _planning(state)
    is_let_out = state.phase is not before.phase and state.phase in LET_OUT
    chosen = next((search for search in state.searches if search.number == look.now.search), None)
    is_other = before.detections is not state.detections
    is_taken = chosen is not None and is_other and chosen.detections == state.detections
    if is_planned or is_let_out:
        look.change(search=None, rejected=False)
    elif before.scan is not state.scan or is_taken:
        look.change(search=None)


def _is_other_scene(before: State, state: State) -> bool:
    """Whether the time and the candidate that were viewed do not matter any more.

    In a recorded session one also goes back, to before the plan was sent.
    """
    is_new = before.plans != state.plans or before.candidates is not state.candidates
    is_sent_now = state.phase is Phase.SENDING and before.phase is not Phase.SENDING
    is_sent_later = state.phase not in SENT and before.phase in SENT
    return is_new or is_sent_now or is_sent_later
