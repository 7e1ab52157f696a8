"""Every configuration in which an arm holds its tool at a pose, or the proof that there is none.

Most six-axis arms have a closed form with up to 16 answers: EAIK finds it from the axes alone
(Ostermeier, Külz and Althoff 2025, doi:10.1109/LRA.2025.3597897).  For all other arms answers
are iterated (`Chain.solve`): from the starts of the caller, and from stored configurations whose
tool is near the pose; for seven axes only where the starts bring no answer.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin
from eaik.pybindings import EAIK
from numba import njit

from workbench.model.cell import Arm
from workbench.model.geometry import Floats, frozen
from workbench.planning.kinematics.chain import Chain, forward, is_solution

if TYPE_CHECKING:
    from scipy.spatial import KDTree

IK_STARTS = 12
"""Starting points of the iterations, home among them."""

SOON = 0.6
"""[s] Half of the random starting points are where joints at full speed get from home in this."""

STORED = 20_000
"""Random configurations whose tool poses are stored, for arms without a closed form."""

STORED_STARTS = 96
"""Stored configurations that are iterated from where the caller's starts bring no answer."""

NEAR_OF_SIX = 256
"""The same for six axes without a closed form, always: their up to 16 branches are all wanted."""

TURN_LENGTH = 0.15
"""[m] What a rotation counts as distance: the norm of the difference of two matrices times this."""

POLISH = 8
"""Iterations by which an answer of the closed form is brought to full precision."""

MOST_TURNS = 4
"""Answers that differ by whole turns of joints, at most for one answer of the closed form: an arm
whose six joints turn twice has 64."""

ITERATED_SAME = 1e-4
"""[rad] Iterations that end this close to each other have found the same configuration."""

AT_LIMIT = 1e-9
"""[rad] Rounding by which an answer may be beyond a joint limit."""


@dataclass(frozen=True, slots=True, eq=False)
class Answers:
    """Configurations `q` (k, n) [rad] with the tool at a pose, all within the limits.

    Where there is none, `nearest` (n,) [rad] comes closest, `away` (2,) [m, rad] from the pose.
    `is_complete`: the closed form has no other answer.  `starts`: how many were iterated from.
    """

    q: Floats
    nearest: Floats
    away: Floats
    is_complete: bool
    starts: int

    @property
    def shortfall(self) -> float:
        """How far the nearest stays away [m]: its distance, and 0.1 m for each radian."""
        return float(self.away @ (1.0, 0.1))


def configurations(
    chain: Chain, T_world_tcp: pin.SE3, starts: Floats, *, turns: int = MOST_TURNS
) -> Answers:
    """The configurations of an arm with its tool at a pose.

    Args:
        chain: of the arm.
        T_world_tcp: where its tool shall be.
        starts: (s, n) [rad] to iterate from where there is no closed form, or no answer.
        turns: how many answers may differ by whole turns of joints: those nearest to the first
            start.
    """
    starts, solver = np.atleast_2d(starts), _closed_form(chain)
    if solver is not None:
        return _by_closed_form(chain, solver, T_world_tcp, starts, turns)
    if len(chain.axes) == 6:
        starts = np.vstack([starts, _store(_key(chain)).near(T_world_tcp, NEAR_OF_SIX)])
        found = _answers(*chain.solve(T_world_tcp, starts), is_complete=False)
        return replace(found, q=_distinct(found.q, ITERATED_SAME))
    answers, residuals = chain.solve(T_world_tcp, starts)
    if not is_solution(residuals).any():
        near = _store(_key(chain)).near(T_world_tcp, STORED_STARTS)
        others, off = chain.solve(T_world_tcp, near)
        answers, residuals = np.vstack([answers, others]), np.vstack([residuals, off])
    return _answers(answers, residuals, is_complete=False)


@lru_cache(maxsize=8)
def starts_of(chain: Chain, arm: Arm, seed: int) -> Floats:
    """Home, the middle of the range, and seeded random configurations, shape (s, n) [rad]."""
    rng = np.random.default_rng(np.random.SeedSequence([seed, ord(arm.controller_id)]))
    home, count = np.asarray(arm.home), (IK_STARTS - 2) // 2
    far = rng.uniform(chain.lower, chain.upper, (count, len(home)))
    near = home + SOON * chain.velocity * rng.uniform(-1.0, 1.0, (count, len(home)))
    near = np.clip(near, chain.lower, chain.upper)
    return frozen(np.vstack([home, (chain.lower + chain.upper) / 2, far, near]))


def _answers(q: Floats, residuals: Floats, *, is_complete: bool) -> Answers:
    nearest = int((residuals @ (1.0, 0.1)).argmin())
    found = q[is_solution(residuals)]
    return Answers(found, q[nearest], residuals[nearest], is_complete, len(q))


# -- the closed form ------------------------------------------------------------------------------


def _closed_form(chain: Chain) -> "EAIK.Robot | None":
    if len(chain.axes) != 6 or chain.slides.any():
        return None
    return _robot(_key(chain))


_Key = tuple[bytes, bytes, bytes, bytes, bytes, bytes]


def _key(chain: Chain) -> _Key:
    """Chains are made for each world: what is known of one is kept by its numbers."""
    R, p, axes, slides, lower, upper = (array.tobytes() for array in chain.arrays)
    return R, p, axes, slides, lower, upper


def _arrays(key: _Key) -> tuple[Floats, Floats, Floats, Floats, Floats, Floats]:
    Rs, ps, axes, slides, lower, upper = (np.frombuffer(buffer).copy() for buffer in key)
    return Rs.reshape(-1, 3, 3), ps.reshape(-1, 3), axes.reshape(-1, 3), slides, lower, upper


@lru_cache(maxsize=32)
def _robot(key: _Key) -> "EAIK.Robot | None":
    """The arm as EAIK describes it: axes and the ways from one to the next, all joints at 0."""
    Rs, ps, axes, *_ = _arrays(key)
    R, p, before = np.eye(3), np.zeros(3), np.zeros(3)
    directions, offsets = [], []
    for k in range(len(ps)):
        p, R = p + R @ ps[k], R @ Rs[k]
        offsets.append(p - before)
        before = p
        if k < len(axes):
            directions.append(R @ axes[k])
    robot = EAIK.Robot(np.array(directions).T, np.array(offsets).T, R, [], True)
    return robot if robot.has_known_decomposition() else None


def _by_closed_form(
    chain: Chain, solver: "EAIK.Robot", T_world_tcp: pin.SE3, starts: Floats, turns: int
) -> Answers:
    found = np.array(solver.calculate_IK(T_world_tcp.homogeneous).Q).reshape(-1, 6)
    found = _turned_nearest(found, chain.lower, chain.upper, starts[0])
    if len(found):
        # Next to a singularity the closed form loses digits; iterations bring them back.
        answers, residuals = chain.solve(T_world_tcp, found, iterations=POLISH)
        if is_solution(residuals).any():
            known = _answers(answers, residuals, is_complete=True)
            q = _distinct(known.q)
            if (chain.upper - chain.lower).max() >= 2 * np.pi and turns > 1:
                q = np.vstack(
                    [_add_turns(configuration, chain, starts[0], turns) for configuration in q]
                )
            return replace(known, q=q)
    answers, residuals = chain.solve(T_world_tcp, starts)
    return _answers(answers, residuals, is_complete=True)


def _turned_nearest(q: Floats, lower: Floats, upper: Floats, home: Floats) -> Floats:
    """Answers (k, n) [rad] of a closed form, each joint turned to be nearest to `home` (n,).

    An answer of which a joint is beyond its limits however it is turned is left out.
    """
    q = q[np.isfinite(q).all(axis=1)]
    q = q + 2 * np.pi * np.round((home - q) / (2 * np.pi))
    q = np.where(q > upper + AT_LIMIT, q - 2 * np.pi, q)
    q = np.where(q < lower - AT_LIMIT, q + 2 * np.pi, q)
    within = ((q >= lower - AT_LIMIT) & (q <= upper + AT_LIMIT)).all(axis=1)
    return np.clip(q[within], lower, upper)


def _add_turns(q: Floats, chain: Chain, home: Floats, most: int) -> Floats:
    """An answer (n,) [rad] with whole turns of its joints, those nearest to `home` first."""
    first = np.ceil((chain.lower - q) / (2 * np.pi))
    last = np.floor((chain.upper - q) / (2 * np.pi))
    counts = [np.arange(a, b + 1) for a, b in zip(first, last, strict=True)]
    every = q + 2 * np.pi * np.array(list(product(*counts))).reshape(-1, len(q))
    far = np.abs(every - home).max(axis=1)
    return every[np.argsort(far, kind="stable")[:most]]


def _distinct(q: Floats, same: float = 1e-6) -> Floats:
    """Rows (k, n) [rad] that no row before is the same as: two branches meet where arms fold."""
    alike = np.abs(q[:, None] - q[None]).max(axis=2) < same
    return q[~np.tril(alike, -1).any(axis=1)]


# -- stored configurations ------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class _Stored:
    """Configurations `q` (m, n) [rad], and a tree of the poses of their tools."""

    q: Floats
    tree: "KDTree"

    def near(self, T_world_tcp: pin.SE3, count: int) -> Floats:
        """Those (count, n) [rad] whose tool is nearest to a pose, nearest first."""
        turns = TURN_LENGTH * T_world_tcp.rotation.ravel()
        _, rows = self.tree.query(np.append(T_world_tcp.translation, turns), k=count)
        return self.q[np.asarray(rows)]


@lru_cache(maxsize=16)
def _store(key: _Key) -> _Stored:
    # Most plans never need it, and it takes a while to import.
    from scipy.spatial import KDTree

    R, p, axes, slides, lower, upper = _arrays(key)
    q = np.random.default_rng(0).uniform(lower, upper, (STORED, len(lower)))
    poses = np.empty((STORED, 12))
    _tool_poses(R, p, axes, slides, q, poses)
    poses[:, 3:] *= TURN_LENGTH
    return _Stored(q, KDTree(poses))


@njit(cache=True)
def _tool_poses(
    Rs: Floats, ps: Floats, axes: Floats, slides: Floats, q: Floats, poses: Floats
) -> None:
    """Write position and rotation of the tool, as rows (m, 12) [m, none], at q (m, n) [rad]."""
    n = len(slides)
    R, p, z, o = np.empty((3, 3)), np.empty(3), np.empty((n, 3)), np.empty((n, 3))
    for k in range(len(q)):
        forward(Rs, ps, axes, slides, q[k], R, p, z, o)
        for i in range(3):
            poses[k, i] = p[i]
            for j in range(3):
                poses[k, 3 + 3 * i + j] = R[i, j]
