"""Where all bodies are, for many configurations at once, and how near they are to each other."""

import math
from collections.abc import Mapping

import numpy as np
import pinocchio as pin

from workbench.model.geometry import Floats, Ints
from workbench.model.plan import Plan
from workbench.proof.bodies import Body, ball, box, coal_shape
from workbench.proof.plane import nearer
from workbench.proof.robot import Tree
from workbench.proof.sieve import Boxes, Chain, World, poses, sieve
from workbench.proof.table import Table

TOUCHING = 1e-4
"""[m] Nearer than this, the line between the nearest points is badly known."""


class Space:
    """The bodies of a scene, which `put` moves from joint to joint.

    `levers` (nq,) [m/rad, m/m]: no point of an empty robot is moved further by a value than that.
    Coal measures at the configuration that was given to `look` last, which is `at` (nq,).
    Concurrency: one thread at a time.
    """

    def __init__(self, tree: Tree, bodies: tuple[Body, ...], table: Table) -> None:
        self.tree, self.bodies, self.table = tree, bodies, table
        self.looks, self.at = 0, tree.rest
        self.joints = np.array([body.joint for body in bodies])
        boxes, at = [box(body.shape) for body in bodies], [body.T_joint_body for body in bodies]
        self._chain = _chain_of(tree)
        self._boxes = Boxes(
            self.joints,
            np.array([T.rotation for T in at]),
            np.array([T.act(c) for T, (c, _) in zip(at, boxes, strict=True)]),
            np.array([half for _, half in boxes]),
            np.array([ball(body.shape)[1] for body in bodies]),
            table.rounds,
        )
        balls = [(b.joint, b.T_joint_body.act(ball(b.shape)[0]), ball(b.shape)[1]) for b in bodies]
        self.levers = np.max([tree.travel(*one) for one in balls], axis=0)
        self._geometry = pin.GeometryModel()
        for number, body in enumerate(bodies):
            shape = coal_shape(body.shape)
            self._geometry.addGeometryObject(
                pin.GeometryObject(str(number), body.joint, body.T_joint_body, shape)
            )
        is_convex = np.array([getattr(body.shape, "is_convex", True) for body in bodies])
        self._are_convex = is_convex[table.first] & is_convex[table.second]
        self._geometry.setCollisionPairs(table.counts, True)
        self._measured = pin.GeometryData(self._geometry)

    def put(self, number: int, joint: int, T_joint_body: pin.SE3) -> None:
        """Hang a body on a joint."""
        self.joints[number] = joint
        self._boxes.turns[number] = T_joint_body.rotation
        self._boxes.centres[number] = T_joint_body.act(box(self.bodies[number].shape)[0])
        shape = self._geometry.geometryObjects[number]
        shape.parentJoint, shape.placement = joint, T_joint_body

    def put_parts(self, plan: Plan, where: Mapping[int, tuple[int, pin.SE3]]) -> None:
        """Have every part lie where the plan has found it, or hang where it was taken to.

        Args:
            plan: the plan.
            where: detection -> joint, and `T_joint_part`; all others lie.
        """
        for number, body in enumerate(self.bodies):
            if body.part >= 0:
                T_world_part = plan.detections[body.part].T_world_part
                joint, T = where.get(body.part, (0, T_world_part))
                self.put(number, joint, T * T_world_part.actInv(body.T_joint_body))

    def look(self, q: Floats) -> None:
        """Measure at this whole configuration (nq,) [rad, m] from now on."""
        self.looks += 1
        self.at = q
        pin.updateGeometryPlacements(
            self.tree.model, self.tree.data, self._geometry, self._measured, q
        )

    def distance(self, row: int) -> float:
        """Between the two of a pair [m]; negative: how deep they are in each other."""
        return float(pin.computeDistance(self._geometry, self._measured, row).min_distance)

    def nearest(self, row: int) -> Floats:
        """Where the two of a pair are nearest (2, 3) [m], in the world, as measured last."""
        result = self._measured.distanceResults[row]
        return np.array([result.getNearestPoint1(), result.getNearestPoint2()])

    def pose(self, number: int) -> pin.SE3:
        """`T_world_body` of a body at the configuration that is looked at."""
        return self._measured.oMg[number]

    def within(
        self, row: int, common: int, k: int, world: World, spans: Floats, corners: Floats
    ) -> float:
        """How near [m] the two of a pair come at least, in the set around what was looked at.

        Args:
            row: which pair, one that was measured since.
            common: the joint next to both that moves both, an index.
            k: which of the sets that follow, an index.
            world: where everything is in the middles of sets.
            spans: see `nearer`.
            corners: see `nearer`.

        Returns:
            A lower bound, minus infinity where nothing can be said.
        """
        result = self._measured.distanceResults[row]
        distance = float(result.min_distance)
        if distance < TOUCHING or not self._are_convex[row]:
            return -np.inf
        way = result.getNearestPoint2() - result.getNearestPoint1()
        normal, chain, boxes = way / math.sqrt(way @ way), self._chain, self._boxes
        first, second = self.table.first[row], self.table.second[row]
        return distance - nearer(
            normal, k, first, second, common, chain, boxes, world, spans, corners
        )

    def bounds(
        self, q: Floats, spans: Floats, items: Ints, rows: Ints, commons: Ints, needs: Floats
    ) -> tuple[Floats, Floats, World]:
        """How far pairs are apart at least, quickly, and how much nearer they may come.

        Args:
            q: whole configurations (k, nq) [rad, m].
            spans: (k, nq) [rad, m] how far each value may be from them.
            items: (n,) at which of them, an index.
            rows: (n,) which pairs, as rows of the table.
            commons: (n,) the joint next to both that moves both, an index.
            needs: (n,) [m] what is enough when the second is taken off the first.

        Returns:
            Both as (n,) [m], and where everything is at the configurations.
        """
        world = poses(self._chain, self._boxes, q)
        first, second = self.table.first[rows], self.table.second[rows]
        chain, boxes = self._chain, self._boxes
        return *sieve(items, first, second, commons, needs, spans, chain, boxes, world), world


def _chain_of(tree: Tree) -> Chain:
    model = tree.model
    joints = [tree.joints.get(j) for j in range(model.njoints)]
    return Chain(
        np.array(list(model.parents)),
        np.array([T.rotation for T in model.jointPlacements]),
        np.array([T.translation for T in model.jointPlacements]),
        np.array([np.zeros(3) if one is None else one.axis for one in joints]),
        np.array([one is not None and one.kind == "prismatic" for one in joints]),
        np.array([max(int(model.joints[j].idx_q), 0) for j in range(model.njoints)]),
    )
