"""All ways in which the grasps of a part put a hand around it.

What a hand has to do with the part that it takes is the same wherever that lies: it is measured
once and remembered.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from workbench.model.cell import Tool
from workbench.model.derived.by_tcp import may_touch
from workbench.model.geometry import Floats, Ints, Solid
from workbench.model.part import Grasp, Part
from workbench.planning.collision.bodies import extent, tool_shapes
from workbench.planning.collision.distances.measuring import distance
from workbench.planning.collision.legs import grips, openings

NO_PAIR = np.iinfo(np.int64).max
"""Instead of the number of a pair: none is too close."""


class Hands(NamedTuple):
    """The ways of some grasps, one after the other: of grasp k those from `first[k]` (k + 1,) on.

    `R` (w, 3, 3) and `p` (w, 3) [m] are the flange seen from the part.  `opening` (w, 2) [m] is
    that of the fingers on arrival and closed, `turn` (w,) which of the `grips` it is.  `cuts`
    (w, 2): solid of the tool times the number of the part's pieces plus the piece that it cuts
    into, or `NO_PAIR`.
    """

    first: Ints
    R: Floats
    p: Floats
    opening: Floats
    turn: Ints
    cuts: Ints

    def some(self, numbers: Ints) -> "Hands":
        """Those with these numbers (n,), where each grasp has one way."""
        return Hands(
            np.arange(len(numbers) + 1),
            np.ascontiguousarray(self.R[numbers]),
            np.ascontiguousarray(self.p[numbers]),
            self.opening[numbers],
            self.turn[numbers],
            self.cuts[numbers],
        )


def closed_press(tool: Tool, part: Part) -> float:
    """How deep [m] a closed hand may be in the bodies of a part, which its tolerance makes larger.

    Fingers stop at the part as it is.  A cup goes as far as planned: its lip alone gives way.
    """
    return tool.press + (part.tolerance or 0.0 if tool.fingers else 0.0)


@lru_cache(maxsize=256)
def hands_of(
    tool: Tool,
    pieces: tuple[Solid, ...],
    grasps: tuple[Grasp, ...],
    least_air: float | None,
    margin: float,
    press: float,
) -> Hands:
    """The ways of grasps in the order in which they are tried: openings, and for each the turns.

    Args:
        tool: the hand.
        pieces: of the part that is taken (`rolled.room_of`).
        grasps: of it.
        least_air: [m] that of the policy (`legs.openings`).
        margin: [m] kept to other things; nearer pieces of the part are measured.
        press: [m] how deep the hand may be in the pieces once it is closed (`closed_press`).
    """
    every = [_hands_of_one(tool, pieces, grasp, least_air, margin, press) for grasp in grasps]
    first = np.cumsum([0, *(len(hands.turn) for hands in every)])
    return Hands(
        first,
        np.concatenate([_NOBODY.R, *(hands.R for hands in every)]),
        np.concatenate([_NOBODY.p, *(hands.p for hands in every)]),
        np.concatenate([_NOBODY.opening, *(hands.opening for hands in every)]),
        np.concatenate([_NOBODY.turn, *(hands.turn for hands in every)]),
        np.concatenate([_NOBODY.cuts, *(hands.cuts for hands in every)]),
    )


_NOBODY = Hands(
    np.zeros(1, np.int64),
    np.zeros((0, 3, 3)),
    np.zeros((0, 3)),
    np.zeros((0, 2)),
    np.zeros(0, np.int64),
    np.zeros((0, 2), np.int64),
)


@lru_cache(maxsize=16384)
def _hands_of_one(
    tool: Tool,
    pieces: tuple[Solid, ...],
    grasp: Grasp,
    least_air: float | None,
    margin: float,
    press: float,
) -> Hands:
    """The ways of one grasp; see `hands_of`."""
    Ts, opened, turn, cuts = [], [], [], []
    has_fingers = bool(tool.fingers)
    hands = [grasp.T_part_tcp * T for T in grips(tool, grasp)]
    closed = [
        cut_of(tool, pieces, T, grasp.grip if has_fingers else 0.0, press, margin) for T in hands
    ]
    for opening in openings(tool, grasp, least_air) if has_fingers else (0.0,):
        for number, T in enumerate(hands):
            Ts.append(T * tool.T_flange_tcp.inverse())
            opened.append((opening, grasp.grip if has_fingers else 0.0))
            turn.append(number)
            open_cut = cut_of(tool, pieces, T, opening, 0.0, margin) if has_fingers else NO_PAIR
            cuts.append((open_cut, closed[number]))
    return Hands(
        np.array([0, len(Ts)]),
        np.array([T.rotation for T in Ts]),
        np.array([T.translation for T in Ts]),
        np.array(opened, dtype=np.float64),
        np.array(turn, dtype=np.int64),
        np.array(cuts, dtype=np.int64),
    )


@lru_cache(maxsize=4096)
def turns_of(tool: Tool, grasp: Grasp) -> Hands:
    """The `grips` of one grasp as ways that are judged each by itself.

    Their fingers arrive as open as the grasp says; what they do to the part is not checked.
    """
    Ts = [grasp.T_part_tcp * T * tool.T_flange_tcp.inverse() for T in grips(tool, grasp)]
    return Hands(
        np.arange(len(Ts) + 1),
        np.array([T.rotation for T in Ts]),
        np.array([T.translation for T in Ts]),
        np.tile([grasp.opening, grasp.grip], (len(Ts), 1)).astype(np.float64),
        np.zeros(len(Ts), np.int64),
        np.full((len(Ts), 2), NO_PAIR),
    )


def cut_of(
    tool: Tool,
    pieces: tuple[Solid, ...],
    T_part_tcp: pin.SE3,
    opening: float,
    press: float,
    margin: float,
) -> int:
    """The first solid of the tool that cuts deeper than `press` [m] into the part, and the piece.

    One that may not touch the part must not cut it at all.  As in `Hands.cuts`.
    """
    balls, boxes, solids = _balls_of(tool), _boxes_of(pieces), tool_shapes(tool)
    R, p = T_part_tcp.rotation, T_part_tcp.translation
    centres = (balls.centres + opening * balls.ways) @ R.T + p
    offsets = np.einsum("nij,tnj->tni", boxes.Rs, centres[:, None] - boxes.centres)
    gaps = np.maximum(np.abs(offsets) - boxes.halves, 0.0)
    near = np.einsum("tni,tni->tn", gaps, gaps) < (balls.radii[:, None] + margin) ** 2
    for number in np.flatnonzero(near.any(axis=1)).tolist():
        T = solids[number].at(tool, T_part_tcp, opening)
        for piece in np.flatnonzero(near[number]).tolist():
            solid = pieces[piece]
            allowed = press if may_touch(tool, solids[number].name) else 0.0
            if distance(solids[number].solid.shape, T, solid.shape, solid.T_owner_shape) < -allowed:
                return number * len(pieces) + piece
    return NO_PAIR


class _Balls(NamedTuple):
    """The balls around a tool's solids: `centres` (t, 3) [m] from its TCP while it is closed.

    `ways` (t, 3) are what they move per opening, without unit; `radii` (t,) [m].
    """

    centres: Floats
    ways: Floats
    radii: Floats


@lru_cache(maxsize=64)
def _balls_of(tool: Tool) -> _Balls:
    solids, T = tool_shapes(tool), tool.T_flange_tcp.inverse()
    return _Balls(
        np.array([T.act(solid.T_flange_body.act(solid.centre)) for solid in solids]).reshape(-1, 3),
        np.array([T.rotation @ solid.direction / 2 for solid in solids]).reshape(-1, 3),
        np.array([solid.radius for solid in solids]),
    )


class _Boxes(NamedTuple):
    """The boxes around a part's pieces, and these: `Rs` (n, 3, 3) turn into their frames.

    `centres` (n, 3) [m] are seen from the part, `halves` (n, 3) [m] half their sizes.
    """

    Rs: Floats
    centres: Floats
    halves: Floats


@lru_cache(maxsize=256)
def _boxes_of(pieces: tuple[Solid, ...]) -> _Boxes:
    poses = [piece.T_owner_shape for piece in pieces]
    extents = [extent(piece.shape) for piece in pieces]
    return _Boxes(
        np.array([T.rotation.T for T in poses]).reshape(-1, 3, 3),
        np.array([T.act(centre) for T, (centre, _, _) in zip(poses, extents, strict=True)]).reshape(
            -1, 3
        ),
        np.array([half for _, half, _ in extents]).reshape(-1, 3),
    )
