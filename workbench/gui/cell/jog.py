"""The robot moved by hand on the page: what meets where it stands, and how the tool can be led."""

from collections.abc import Mapping

import numpy as np
import pinocchio as pin

from workbench.app.core.state import State
from workbench.gui.shared.look import Jogged
from workbench.model.geometry import Floats
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.planning.kinematics.chain import Chain, is_solution

IK_STARTS = 12
"""Starting points of the inverse kinematics beside the configuration at hand."""

SEARCHED_WITHIN = 0.3
"""[rad] How far they lie from it at most."""

SHOWN_WITHIN = 0.1
"""[m] Pairs further apart than this need not be reported."""


class JogFinder:
    """Says what a jogged robot is close to; keeps the world it has asked last.

    Concurrency: one thread.
    """

    def __init__(self) -> None:
        self._key: tuple[object, ...] = ()
        self._world: World | None = None

    def check_jog(self, state: State, q: Mapping[str, Floats]) -> Jogged:
        """What meets when the named arms stand at `q` (n,) [rad], fingers open, others at home."""
        key = (state.cell, state.detections, state.obstacles)
        if self._world is None or any(a is not b for a, b in zip(key, self._key, strict=True)):
            self._world = World(state.cell, state.detections or (), state.obstacles)
            self._key = key
        world = self._world
        openings = {arm.name: arm.tool.stroke[1] for arm in state.cell.arms}
        world.enter(LegPhase(frozenset(openings), openings))
        whole = world.configuration(q)
        contacts = world.contacts(whole)
        meets = tuple(
            touch for contact in contacts for touch in world.place_shapes(whole, contact.pair)
        )
        clearance, pair = world.clearance(whole, SHOWN_WITHIN)
        return Jogged(dict(q), contacts, clearance, pair, meets)


def lead_to(chain: Chain, q: Floats, T_world_tcp: pin.SE3) -> Floats | None:
    """The configuration (n,) [rad] nearest to `q` with the tool at a pose; None out of reach."""
    rng = np.random.default_rng(0)
    near = q + rng.uniform(-SEARCHED_WITHIN, SEARCHED_WITHIN, (IK_STARTS, len(q)))
    answers, residuals = chain.solve(T_world_tcp, np.vstack([q, near]))
    found = answers[is_solution(residuals)]
    if not len(found):
        return None
    return found[np.abs(found - q).max(axis=1).argmin()]
