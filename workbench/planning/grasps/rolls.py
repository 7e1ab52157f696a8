"""Parts of unknown roll: what holds for every roll, and the messages about it."""

from collections.abc import Sequence
from dataclasses import replace

from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.cell import Arm
from workbench.model.messages.message import all_of, found_part
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.part import Grasp, Part
from workbench.model.scan import Detection
from workbench.planning.collision.bodies import part_label, tool_shapes
from workbench.planning.collision.hands import NO_PAIR, closed_press, cut_of, turns_of
from workbench.planning.collision.legs import grips
from workbench.planning.collision.tool_check import Fit, ToolCheck
from workbench.planning.grasps.roll_symmetry import uneven


def at_every_turn(
    check: ToolCheck,
    part: Part,
    detections: Sequence[Detection],
    number: int,
    *,
    arm: Arm,
    grasp: Grasp,
    fit: Fit,
    verdict: Verdict,
) -> Verdict:
    """The first verdict on a hand at a part that may be rolled, as far as that is not known.

    Args:
        check: in which the hand was checked.
        part: that is taken.
        detections: all of them.
        number: of that of the part.
        arm: that takes it.
        grasp: by which.
        fit: how the hand fits.
        verdict: what that comes to.

    Returns:
        The same where the roll is known.
    """
    detection = detections[number]
    if detection.roll_known:
        return with_rolls(detections, verdict)
    if arm.needs_roll:
        count = len(arm.Ts_world_place) + len(arm.part_places)
        needed = VerdictNote.PLACES_NEED_ROLL(count=count, arm=arm.name)
        note = all_of((needed, VerdictNote.ROLL_UNSEEN()))
        return Verdict(Reason.ROLL_UNKNOWN, Stage.PROPOSE, note=note)
    if not verdict.is_ok:
        is_own = verdict.pair is not None and verdict.pair[1] == part_label(number)
        if is_own and not _cuts(part, arm, grasp, fit):
            unknown = replace(verdict, reason=Reason.ROLL_UNKNOWN)
            return unknown.with_note(VerdictNote.ROLL_UNSEEN())
        return with_rolls(detections, verdict)
    wrong = uneven(part, detection, arm, grasp)
    first = wrong[fit.turn]
    if first is None:
        return verdict
    free = check.free(arm, number, turns_of(arm.tool, grasp))
    if any(fits and what is None for fits, what in zip(free, wrong, strict=True)):
        return verdict
    pair = (f"{arm.name} {tool_shapes(arm.tool)[-1].name}", part_label(number))
    note = all_of((first.message, VerdictNote.ROLL_UNSEEN()))
    return Verdict(Reason.ROLL_UNKNOWN, Stage.PROPOSE, pair, note=note)


def with_rolls(detections: Sequence[Detection], verdict: Verdict) -> Verdict:
    """A verdict that says so where a part of its pair counts with the room of all its turns."""
    if verdict.pair is None or verdict.reason is Reason.ROLL_UNKNOWN:
        return verdict
    labels = [
        part_label(number)
        for number, detection in enumerate(detections)
        if not detection.roll_known
    ]
    rolled = [label for label in verdict.pair if label in labels]
    if not rolled:
        return verdict
    return verdict.with_note(VerdictNote.ALL_TURNS(parts=map(found_part, rolled)))


def _cuts(part: Part, arm: Arm, grasp: Grasp, fit: Fit) -> bool:
    """Whether a hand is in the part also as that was found."""
    T = grasp.T_part_tcp * grips(arm.tool, grasp)[fit.turn]
    opening, press = fit.opening, 0.0
    if fit.is_closed or not arm.tool.fingers:
        opening, press = grasp.grip if arm.tool.fingers else 0.0, closed_press(arm.tool, part)
    return cut_of(arm.tool, part.pieces, T, opening, press, 0.0) != NO_PAIR
