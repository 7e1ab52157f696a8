"""Applies the nearest fix: the command that changes grasp or policy as in the trial."""

import math
from dataclasses import replace

import numpy as np
import pinocchio as pin

from workbench.app.core.cell.changes import ChangeCell
from workbench.app.core.cell.part_edits import EditPart
from workbench.app.core.state import State
from workbench.model.cell import Policy
from workbench.model.errors import InputError
from workbench.model.messages.grasps import FixText
from workbench.model.messages.message import Message
from workbench.model.part import Grasp, GraspPattern, widen_grasp
from workbench.model.part_edits import grasp_of, with_grasp
from workbench.planning.picking.nearest_fix import Fix

SAME_LENGTH, SAME_ANGLE = 5e-5, math.radians(0.05)
"""[m], [rad] Smaller differences are not visible in the displayed digits."""


def make_fix_command(state: State, fix: Fix) -> EditPart | ChangeCell:
    """The command that makes the change of a fix; an undo takes it back.

    A grasp is changed for all parts of its kind, a pattern with all its copies.

    Args:
        state: with the candidates that the fix was found for.
        fix: of one of them.

    Raises:
        InputError: the candidate is not among the latest, its grasp is gone, or the change is
            neither of a grasp nor of the policy.
    """
    candidate = fix.candidate
    # A plan made meanwhile has judged others.
    if not any(candidate is other for other in state.candidates or ()):
        raise InputError(FixText.OUTDATED())
    says = FixText.APPLIED(grasp=candidate.grasp.name, change=fix.change)
    if fix.grasp is None:
        if fix.policy is None:
            raise InputError(FixText.NOT_HERE(change=fix.change))
        says = FixText.APPLIED_TO_CELL(change=fix.change)
        after = replace(state.cell, policy=fix.policy)
        return ChangeCell(after, says, was=state.cell.digest)
    part = state.cell.part((state.detections or ())[candidate.detection].part)
    entry = part.library.entry_of(candidate.grasp.name)
    if entry is None:
        raise InputError(FixText.GRASP_GONE(grasp=repr(candidate.grasp.name)))
    authored = grasp_of(entry)
    # A copy made by a pattern or a symmetry moves with the grasp that it is a copy of.
    changed = replace(
        authored,
        T_part_tcp=authored.T_part_tcp * candidate.grasp.T_part_tcp.actInv(fix.grasp.T_part_tcp),
    )
    # The candidate's fingers may be less open than the grasp says, where only that fits.
    if fix.grasp.opening != candidate.grasp.opening:
        # Without the room for the part's tolerance, which is added when it is used.
        as_authored = widen_grasp(fix.grasp, -(part.tolerance or 0.0))
        changed = replace(changed, opening=as_authored.opening)
    return EditPart(part.name, (entry,), (with_grasp(entry, changed),), says=says)


def explain_fix(state: State, fix: Fix) -> Message | None:
    """What a fix would change, from what to what and for what; None where nothing can make it.

    Lengths and angles are those of the fields in the tab Grasps.

    Args:
        state: with the candidates that the fix was found for.
        fix: of one of them.
    """
    try:
        command = make_fix_command(state, fix)
    except InputError:
        return None
    if isinstance(command, ChangeCell):
        return FixText.ON_CELL(changes=_policy_changes(state.cell.policy, command.cell.policy))
    entry, changed = command.was[0], command.now[0]
    text = FixText.ON_PATTERN if isinstance(entry, GraspPattern) else FixText.ON_GRASP
    changes = _grasp_changes(grasp_of(entry), grasp_of(changed))
    return text(grasp=entry.name, part=command.part, changes=changes)


def _policy_changes(before: Policy, after: Policy) -> list[Message]:
    changes: list[Message] = []
    if before.near_margin != after.near_margin:
        margins = {"before": before.near_margin, "after": after.near_margin}
        changes.append(FixText.LENGTH(name="near_margin", **margins))
    if before.lifts != after.lifts:
        changes.append(FixText.LIFTS_CHANGED(before=before.lifts, after=after.lifts))
    return changes


def _grasp_changes(before: Grasp, after: Grasp) -> list[Message]:
    T, T_after = before.T_part_tcp, after.T_part_tcp
    lengths = [*zip("xyz", T.translation, T_after.translation, strict=True)]
    lengths.append(("opening", before.opening, after.opening))
    changes: list[Message] = [
        FixText.LENGTH(name=name, before=float(old), after=float(new))
        for name, old, new in lengths
        if abs(old - new) > SAME_LENGTH
    ]
    angles = (pin.rpy.matrixToRpy(pose.rotation) for pose in (T, T_after))
    changes += [
        FixText.ANGLE(name=name, before=float(old), after=float(new))
        for name, old, new in zip(("roll", "pitch", "yaw"), *angles, strict=True)
        if abs(np.angle(np.exp(1j * (new - old)))) > SAME_ANGLE
    ]
    return changes
