"""How near a proven plan comes to anything, and how fast it gets, for people."""

from workbench.model.messages.message import Message, all_of
from workbench.model.messages.states import ClearanceText
from workbench.model.motion import ceil_energy, ceil_speed, floor_distance, greatest_speed
from workbench.model.plan import Proof
from workbench.proof.claims.stages import NEAR_MARGIN_LEGS


def linear_clearance(proof: Proof) -> float | None:
    """The least distance [m] on linear motion, where the tool may come near; None without any."""
    found = [
        float(bounds.min())
        for _, leg, bounds in proof.clearances
        if leg in NEAR_MARGIN_LEGS and len(bounds)
    ]
    return min(found) if found else None


def bounds_message(proof: Proof) -> Message:
    """What a proof bounds: both least distances, and speeds where the cell limits them."""
    clearance, speed = clearance_message(proof), speed_message(proof)
    return clearance if speed is None else all_of((clearance, speed)) or clearance


def speed_message(proof: Proof) -> Message | None:
    """How fast points and the TCP get at most, and with what energy; None without limits."""
    fast = greatest_speed(proof.speeds)
    if fast is None:
        return None
    speeds = ClearanceText.SPEEDS(point=ceil_speed(fast.point), tcp=ceil_speed(fast.tcp))
    energies = [bound.energy for bound in proof.speeds if bound.energy is not None]
    if not energies:
        return speeds
    return all_of((speeds, ClearanceText.ENERGY(energy=ceil_energy(max(energies)))))


def clearance_message(proof: Proof) -> Message:
    """Both least distances of a plan, from below."""
    free, linear = floor_distance(proof.clearance), linear_clearance(proof)
    if linear is None:
        return ClearanceText.FREE(free=free)
    return ClearanceText.BOTH(free=free, linear=floor_distance(max(linear, 0.0)))
