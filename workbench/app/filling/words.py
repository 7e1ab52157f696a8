"""What came of filling a library, in sentences."""

from workbench.app.filling.fill import Filled
from workbench.model.candidate import Reason


def filled_words(found: Filled) -> list[str]:
    """How much of the simulated piles comes out, why the rest stays, and what would take it."""
    words = [
        f"{found.taken} of {found.parts} parts in simulated piles come out, without looking for "
        f"paths; {found.seconds:.0f} s of processor time"
    ]
    if found.stays:
        why = ", ".join(f"{count} {reason}" for reason, count in found.stays)
        words.append(f"no grip of the tools takes the others as they lie: {why}")
    if found.lifts == 1 and dict(found.stays).get(str(Reason.EXTRACT_BLOCKED)):
        words.append('more lifts may take what cannot be lifted: emptying = "thorough" in [policy]')
    if found.looked and found.helps:
        helps = ", ".join(f"{count} with {change}" for change, count in found.helps)
        words.append(
            f"no hand fits at {found.looked} parts that were looked at; it would at {helps}"
        )
    elif found.looked:
        words.append(
            f"no hand fits at {found.looked} parts that were looked at, also with thinner fingers, "
            "lower walls or a cup of 8 mm"
        )
    return words
