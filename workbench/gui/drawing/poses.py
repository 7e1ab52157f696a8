"""The poses in which a candidate can be viewed: its way, or where it was refused."""

import numpy as np

from workbench.app.core.state import State
from workbench.gui.drawing.refusals import refused_pose
from workbench.gui.shared.look import Pose
from workbench.gui.texts.scene import PosePageText
from workbench.model.candidate import Candidate, Pick
from workbench.model.cell import Cell
from workbench.model.derived.by_tcp import by_taking
from workbench.model.geometry import Floats
from workbench.model.messages.message import FoundPart, Message, found_part
from workbench.model.scan import Detection, Obstacle
from workbench.planning.collision.world import World
from workbench.planning.kinematics.self_motion import self_motion
from workbench.planning.picking.resolve import approach_phase, resolve


class PoseFinder:
    """Works out the poses of a candidate; keeps the world of the parts that were found last.

    Concurrency: one thread.
    """

    def __init__(self) -> None:
        self._world: World | None = None

    def poses(self, state: State, candidate: Candidate) -> tuple[Pose, ...]:
        """Where it failed; or pre-grasp, grasp, lifted and place, and the elbow's freedom."""
        if not state.detections:
            return ()
        cell = by_taking(state.cell, candidate)
        world = self._world_of(cell, state.detections, state.obstacles)
        if not candidate.verdict.is_ok:
            pose = refused_pose(world, candidate)
            return () if pose is None else (pose,)
        pick = resolve(world, candidate, seed=state.plan.seed if state.plan is not None else 0)
        return self._on_the_way(world, pick) if isinstance(pick, Pick) else ()

    def _world_of(
        self, cell: Cell, detections: tuple[Detection, ...], obstacles: tuple[Obstacle, ...]
    ) -> World:
        """The world of these parts: that from before where nothing is other than it was."""
        world = self._world
        if (
            world is None
            or world.cell is not cell
            or world.detections is not detections
            or world.obstacles is not obstacles
        ):
            world = self._world = World(cell, detections, obstacles)
        return world

    def _on_the_way(self, world: World, pick: Pick) -> tuple[Pose, ...]:
        candidate, opening = pick.candidate, pick.candidate.grasp.opening
        place = np.atleast_2d(pick.place)[-1]
        part = FoundPart(candidate.detection)
        keeps = PosePageText.CLEAR_NEAR(margin=world.policy.near_margin, part=part)
        touches, leaves = PosePageText.CLEAR_TOUCH(part=part), PosePageText.CLEAR_LEAVE(part=part)
        way = [
            Pose("pre-grasp", np.asarray(pick.approach[0]), opening, keeps),
            Pose("grasp", pick.q_grasp, opening, touches),
            Pose("lifted", np.asarray(pick.extract[-1]), candidate.grasp.grip, leaves),
            Pose("place", place, candidate.grasp.grip, "clear"),
        ]
        world.enter(approach_phase(candidate, world.arm(candidate.arm)))
        turned = self_motion(world.chains[candidate.arm], pick.q_grasp)
        others = [np.asarray(q) for q in pick.solutions if np.abs(q - pick.q_grasp).max() > 1e-3]
        if len(turned) > 1:
            way += [
                self._looked_at(
                    world, candidate, q, PosePageText.ELBOW(number=k, count=len(turned))
                )
                for k, q in enumerate(turned, start=1)
            ]
        way += [
            self._looked_at(world, candidate, q, PosePageText.SOLUTION(number=k, count=len(others)))
            for k, q in enumerate(others, start=1)
        ]
        return tuple(way)

    def _looked_at(self, world: World, candidate: Candidate, q: Floats, label: Message) -> Pose:
        whole = world.configuration({candidate.arm: q})
        contact = world.contact(whole)
        opening = candidate.grasp.opening
        if contact is None:
            return Pose(label, q, opening, "clear")
        first, second = map(found_part, contact.pair)
        note = PosePageText.PAIR(first=first, second=second, distance=contact.distance)
        return Pose(label, q, opening, note, world.place_shapes(whole, contact.pair))
