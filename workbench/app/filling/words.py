"""What came of filling a library, in sentences."""

from workbench.app.filling.advice import CUP_WIDTH
from workbench.app.filling.fill import Filled
from workbench.app.filling.for_remaining import Proposal
from workbench.model.messages.changes import FillText, RemainText
from workbench.model.messages.message import Message
from workbench.model.messages.verdicts import ReasonText


def filled_words(found: Filled) -> list[Message]:
    """How much of the simulated piles comes out, why the rest stays, and what would take it."""
    says = [FillText.TAKEN(taken=found.taken, parts=found.parts, seconds=found.seconds)]
    if found.stays:
        reasons = [FillText.COUNTED(count=count, reason=why) for why, count in found.stays]
        says.append(FillText.STAYS(reasons=reasons))
    is_blocked = any(why.text is ReasonText.EXTRACT_BLOCKED for why, _ in found.stays)
    if found.lifts == 1 and is_blocked:
        says.append(FillText.MORE_LIFTS())
    if found.looked and found.helps:
        helps = [FillText.HELPED(count=count, change=change) for change, count in found.helps]
        says.append(FillText.HELPS(looked=found.looked, helps=helps))
    elif found.looked:
        says.append(FillText.NOTHING_HELPS(looked=found.looked, cup=CUP_WIDTH))
    return says


def proposal_words(part: str, found: Proposal) -> list[Message]:
    """What came of looking for grasps of the parts of a kind that stayed."""
    says: list[Message] = []
    if found.known:
        says.append(RemainText.KNOWN(known=found.known, looked=found.looked, part=part))
    if found.entries:
        names = ", ".join(entry.name for entry in found.entries)
        says.append(
            RemainText.ADDED(added=found.added, looked=found.looked, part=part, names=names)
        )
    return says or [RemainText.NONE(looked=found.looked, part=part)]
