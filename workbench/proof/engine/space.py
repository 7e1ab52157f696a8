"""Where all bodies are, and how near they are to each other."""

from collections.abc import Mapping, Sequence

import coal
import numpy as np
import pinocchio as pin

from workbench.model.geometry import Bools, Floats, Ints
from workbench.proof.engine.bodies import CheckedBody
from workbench.proof.engine.frames import Bodies, JointTree, levers, poses
from workbench.proof.engine.pairs import BodyPairs
from workbench.proof.engine.robot import Tree
from workbench.proof.engine.shapes import coal_shape, hull, is_divided, measure

REQUEST = coal.DistanceRequest()
REQUEST.gjk_initial_guess = coal.GJKInitialGuess.CachedGuess
"""Coal begins with what it found of a pair before."""


class Space:
    """The bodies of a scene, which `put` moves from joint to joint.

    `chain` and `arrays` are its joints and bodies for what is compiled, `levers` (nq,) [m/rad, m/m]
    about how far each value moves the farthest body.  `normals` (b, b, 2, 3) are directions in
    which pairs were once apart, see `sieve`.
    Coal measures at the configuration that was given to `look` last, which is `at` (nq,).
    Concurrency: one thread at a time.
    """

    def __init__(self, tree: Tree, bodies: tuple[CheckedBody, ...], table: BodyPairs) -> None:
        self.tree, self.bodies, self.table = tree, bodies, table
        self.looks, self.at = 0, tree.rest
        self.chain, self.arrays = chain_of(tree), arrays_of(bodies, table.rounds)
        self.joints = self.arrays.joints
        rest, every = tree.rest[None], np.ones(len(bodies), bool)
        world = poses(self.chain, self.arrays, rest, np.zeros_like(rest), every)
        self.levers = levers(self.chain, self.arrays, world)
        self.normals = np.zeros((len(bodies), len(bodies), 2, 3))
        self._geometry = pin.GeometryModel()
        for number, body in enumerate(bodies):
            shape = coal_shape(body.shape)
            self._geometry.addGeometryObject(
                pin.GeometryObject(str(number), body.joint, body.T_joint_body, shape)
            )
        self._measured = pin.GeometryData(self._geometry)
        self._is_divided = [is_divided(body.shape) for body in bodies]
        self._numbers: dict[int, int] = {}
        self._last = coal.DistanceResult()

    def put(self, number: int, joint: int, T_joint_body: pin.SE3) -> None:
        """Hang a body on a joint."""
        self.joints[number] = joint
        self.arrays.turns[number] = T_joint_body.rotation
        self.arrays.centres[number] = T_joint_body.act(hull(self.bodies[number].shape).centre)
        shape = self._geometry.geometryObjects[number]
        shape.parentJoint, shape.placement = joint, T_joint_body

    def put_parts(self, found: Sequence[pin.SE3], where: Mapping[int, tuple[int, pin.SE3]]) -> None:
        """Have every part lie where it was found, or hang where it was taken to.

        Args:
            found: each detection's `T_world_part` (SE3).
            where: detection -> joint, and `T_joint_part`; all others lie.
        """
        for number, body in enumerate(self.bodies):
            if body.part >= 0:
                T_world_part = found[body.part]
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
        pair = int(self.table.first[row]), int(self.table.second[row])
        if self._is_divided[pair[0]] or self._is_divided[pair[1]]:
            first, second = ((self.bodies[k].shape, self._measured.oMg[k]) for k in pair)
            self._last = measure(first, second)
            return float(self._last.min_distance)
        number = self._numbers.get(row)
        if number is None:
            number = self._numbers[row] = self._add_pair(row)
        self._last = pin.computeDistance(self._geometry, self._measured, number)
        return float(self._last.min_distance)

    def _add_pair(self, row: int) -> int:
        """Make room for measuring a pair, as Pinocchio does: for all of them it would take long."""
        pair, measured = (int(self.table.first[row]), int(self.table.second[row])), self._measured
        self._geometry.addCollisionPair(pin.CollisionPair(*pair))
        shapes = (self._geometry.geometryObjects[number] for number in pair)
        measured.distance_functors.append(pin.ComputeDistance(*shapes))
        measured.distanceRequests.append(REQUEST)
        measured.distanceResults.append(coal.DistanceResult())
        measured.collisionResults.append(coal.CollisionResult())
        return len(self._numbers)

    def nearest(self) -> Floats:
        """Where the two that were measured last are nearest (2, 3) [m], in the world."""
        return np.array([self._last.getNearestPoint1(), self._last.getNearestPoint2()])

    def way(self) -> Floats:
        """From the nearest point of the one to that of the other (3,) [m], as measured last."""
        return self._last.getNearestPoint2() - self._last.getNearestPoint1()

    def has_direction(self, rows: Ints) -> Bools:
        """Whether a direction is known in which the two of pairs (r,) were once apart."""
        normals = self.normals[self.table.first[rows], self.table.second[rows], 0]
        return np.asarray(normals.any(axis=1), dtype=np.bool_)

    def pose(self, number: int) -> pin.SE3:
        """`T_world_body` of a body at the configuration that is checked."""
        return self._measured.oMg[number]


def arrays_of(bodies: tuple[CheckedBody, ...], rounds: Bools) -> Bodies:
    """Bodies to be compiled for; `rounds` (b,), no unit, fill the same space at every turn."""
    at, hulls = [body.T_joint_body for body in bodies], [hull(body.shape) for body in bodies]
    return Bodies(
        np.array([body.joint for body in bodies]),
        np.array([T.rotation for T in at]),
        np.array([T.act(convex.centre) for T, convex in zip(at, hulls, strict=True)]),
        np.array([convex.half for convex in hulls]),
        np.array([convex.radius for convex in hulls]),
        rounds,
        np.concatenate([convex.points for convex in hulls]),
        np.cumsum([0, *(len(convex.points) for convex in hulls)]),
        np.array([convex.box for convex in hulls]),
        np.array([convex.disc for convex in hulls]),
        np.array([convex.ball for convex in hulls]),
    )


def chain_of(tree: Tree) -> JointTree:
    """The joints of a robot for what is compiled."""
    model = tree.model
    joints = [tree.joints.get(j) for j in range(model.njoints)]
    return JointTree(
        np.array(list(model.parents)),
        np.array([T.rotation for T in model.jointPlacements]),
        np.array([T.translation for T in model.jointPlacements]),
        np.array([np.zeros(3) if joint is None else joint.axis for joint in joints]),
        np.array([joint is not None and joint.kind == "prismatic" for joint in joints]),
        np.array([max(int(model.joints[j].idx_q), 0) for j in range(model.njoints)]),
    )
