"""The nearest fix carried out: the command that changes grasp or policy as it was tried."""

from dataclasses import replace

from workbench.app.core.cell.changes import ChangeCell
from workbench.app.core.cell.part_edits import EditPart
from workbench.app.core.state import State
from workbench.model.errors import InputError
from workbench.model.messages.grasps import FixText
from workbench.model.part import widen_grasp
from workbench.model.part_edits import grasp_of, with_grasp
from workbench.planning.picking.nearest_fix import Fix


def make_fix_command(state: State, fix: Fix) -> EditPart | ChangeCell:
    """The command that makes the change of a fix; an undo takes it back.

    A grasp is changed for all parts of its kind, a pattern with all its copies.

    Args:
        state: with the candidates that the fix was found for.
        fix: of one of them.

    Raises:
        InputError: the candidate is not among those judged last, its grasp is gone, or the change
            is neither of a grasp nor of the policy.
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
        return ChangeCell(replace(state.cell, policy=fix.policy), says)
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
