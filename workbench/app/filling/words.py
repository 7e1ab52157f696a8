"""What came of filling a library, in sentences."""

from workbench.app.filling.fill import Filled


def filled_words(found: Filled) -> list[str]:
    """How much of the simulated piles comes out, why the rest stays, and what would take it."""
    words = [
        f"{found.taken} of {found.parts} parts in simulated piles come out, without looking for "
        f"paths; {found.seconds:.0f} s of processor time"
    ]
    if found.stays:
        why = ", ".join(f"{count} {reason}" for reason, count in found.stays)
        words.append(f"no grip of the tools takes the others as they lie: {why}")
    if found.looked and found.helps:
        helps = ", ".join(f"{change}: {count}" for change, count in found.helps)
        words.append(f"of {found.looked} of these a hand would fit at, with {helps}")
    elif found.looked:
        words.append("neither thinner fingers, lower walls nor a small cup would take them")
    return words
