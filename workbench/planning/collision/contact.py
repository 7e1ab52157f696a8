"""What the world answers: what is too close, and how far a motion is clear."""

from dataclasses import dataclass

from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.geometry import Floats, Ints
from workbench.model.messages.message import Message


@dataclass(frozen=True, slots=True, eq=False)
class Contact:
    """A pair that is too close: `distance` [m] (negative: penetration) is below `margin` [m]."""

    pair: tuple[str, str]
    distance: float
    margin: float

    def refuse(
        self, reason: Reason, stage: Stage, q: Floats, note: Message | None = None
    ) -> Verdict:
        """The verdict on a configuration (n,) [rad] with this contact."""
        return Verdict(reason, stage, self.pair, self.distance, q, note)


@dataclass(frozen=True, slots=True, eq=False)
class Swept:
    """How far compiled code has come along a chain of curves.

    `clear`: this many curves are clear of all pairs but those in `left`, which have to be checked
    otherwise.  On the curve after them is `met`, a contact with the arm's configuration
    (n,) [rad] there; where that is None and a curve remains, all of that one has to be checked
    otherwise.
    """

    clear: int
    met: tuple[Contact, Floats] | None
    left: Ints
