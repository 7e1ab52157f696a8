"""The poses in which a candidate can be looked at: its way, or where it failed and what meets."""

import numpy as np

from workbench.app.core.state import State
from workbench.gui.shared.look import Pose
from workbench.gui.shared.views import mm, verdict_words
from workbench.model.candidate import Candidate, Pick
from workbench.model.geometry import Floats
from workbench.model.scan import Detection, Obstacle
from workbench.planning.collision.world import World
from workbench.planning.kinematics.self_motion import self_motion
from workbench.planning.picking.resolve import approach_phase, resolve


class PoseFinder:
    """Works out the poses of a candidate; keeps the world of the parts that were found last.

    Concurrency: one thread.
    """

    def __init__(self) -> None:
        self._detections: tuple[Detection, ...] | None = None
        self._obstacles: tuple[Obstacle, ...] = ()
        self._world: World | None = None

    def poses(self, state: State, candidate: Candidate) -> tuple[Pose, ...]:
        """Where it failed; or pre-grasp, grasp, lifted and place, and the elbow's freedom."""
        if not state.detections:
            return ()
        if self._world is None or not self._is_current(state):
            self._world = World(state.cell, state.detections, state.obstacles)
            self._detections, self._obstacles = state.detections, state.obstacles
        world, verdict = self._world, candidate.verdict
        if not verdict.is_ok:
            if verdict.q is None or len(verdict.q) != len(world.arm(candidate.arm).joints):
                return ()
            return (self._failed(world, candidate, np.asarray(verdict.q)),)
        pick = resolve(world, candidate, seed=state.plan.seed if state.plan is not None else 0)
        return self._on_the_way(world, pick) if isinstance(pick, Pick) else ()

    def _is_current(self, state: State) -> bool:
        return self._detections is state.detections and self._obstacles is state.obstacles

    def _failed(self, world: World, candidate: Candidate, q: Floats) -> Pose:
        verdict = candidate.verdict
        world.enter(approach_phase(candidate, world.arm(candidate.arm)))
        whole = world.configuration({candidate.arm: q})
        meets = () if verdict.pair is None else world.placed(whole, verdict.pair)
        note = verdict_words(verdict)
        return Pose(f"where it failed: {verdict.stage}", q, candidate.grasp.opening, note, meets)

    def _on_the_way(self, world: World, pick: Pick) -> tuple[Pose, ...]:
        candidate, opening = pick.candidate, pick.candidate.grasp.opening
        place = np.atleast_2d(pick.place)[-1]
        part, near = f"part-{candidate.detection + 1}", mm(world.policy.near_margin)
        keeps = f"clear; straight on the tool keeps {near} from all but {part}"
        leaves = f"clear; {part} may leave what it lies on, but not come nearer"
        way = [
            Pose("pre-grasp", np.asarray(pick.approach[0]), opening, keeps),
            Pose("grasp", pick.q_grasp, opening, f"clear; the tool may touch {part}"),
            Pose("lifted", np.asarray(pick.extract[-1]), candidate.grasp.grip, leaves),
            Pose("place", place, candidate.grasp.grip, "clear"),
        ]
        world.enter(approach_phase(candidate, world.arm(candidate.arm)))
        turned = self_motion(world.chains[candidate.arm], pick.q_grasp)
        others = [np.asarray(q) for q in pick.solutions if np.abs(q - pick.q_grasp).max() > 1e-3]
        if len(turned) > 1:
            way += [
                self._looked_at(world, candidate, q, f"grasp, elbow {k} of {len(turned)}")
                for k, q in enumerate(turned, start=1)
            ]
        way += [
            self._looked_at(world, candidate, q, f"grasp, solution {k} of {len(others)}")
            for k, q in enumerate(others, start=1)
        ]
        return tuple(way)

    def _looked_at(self, world: World, candidate: Candidate, q: Floats, label: str) -> Pose:
        whole = world.configuration({candidate.arm: q})
        contact = world.contact(whole)
        opening = candidate.grasp.opening
        if contact is None:
            return Pose(label, q, opening, "clear")
        note = f"{contact.pair[0]} and {contact.pair[1]}, {mm(contact.distance)}"
        return Pose(label, q, opening, note, world.placed(whole, contact.pair))
