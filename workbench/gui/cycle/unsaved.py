"""What a plan rests on that no file has: changes of cell or grasps that nobody has saved."""

from workbench.app.core.state import State
from workbench.gui.texts.approval import ApprovalText
from workbench.model.messages.message import Message


def unsaved_message(state: State) -> Message | None:
    """The changes since the cell's files were saved; None where they have all of it."""
    if state.is_saved:
        return None
    # The newest change is the first; below the saved cell are those that it has.
    digests = [edited.cell.digest for edited in state.before]
    if state.saved not in digests:
        return ApprovalText.UNSAVED()
    count = digests.index(state.saved) + 1
    return ApprovalText.UNSAVED_CHANGES(count=count, change=state.before[0].change)
