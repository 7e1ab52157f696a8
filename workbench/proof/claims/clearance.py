"""How near a proven plan comes to anything, for people: on free and on linear motion."""

from workbench.model.messages.message import Message
from workbench.model.messages.states import ClearanceText
from workbench.model.plan import Proof, floor_distance
from workbench.proof.claims.stages import NEAR_MARGIN_LEGS


def linear_clearance(proof: Proof) -> float | None:
    """The least distance [m] on linear motion, where the tool may come near; None without any."""
    found = [
        float(bounds.min())
        for _, leg, bounds in proof.clearances
        if leg in NEAR_MARGIN_LEGS and len(bounds)
    ]
    return min(found) if found else None


def clearance_message(proof: Proof) -> Message:
    """Both least distances of a plan, from below."""
    free, linear = floor_distance(proof.clearance), linear_clearance(proof)
    if linear is None:
        return ClearanceText.FREE(free=free)
    return ClearanceText.BOTH(free=free, linear=floor_distance(max(linear, 0.0)))
