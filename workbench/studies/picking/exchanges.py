"""Whether a part could go from one hand to the other in the air: a search, and no plan.

Asked is less than a plan would have to be: one hand lifts the part out of the bin, both hold it at
one pose without meeting anything; the second one comes and the first one leaves on a linear motion,
and the second one holds it so that it comes to its place.  The free motions between are not looked
for.  So what is counted is the most that a handover could bring, by the poses that are tried.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from functools import cached_property
from itertools import product

import numpy as np
import pinocchio as pin

from workbench.model.candidate import Pick
from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats
from workbench.model.part import Grasp
from workbench.model.scan import Detection
from workbench.planning.collision.legs import grips, hand_turns
from workbench.planning.collision.motion import path_contact
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.planning.kinematics.chain import is_solution
from workbench.planning.kinematics.inverse import starts_of
from workbench.planning.kinematics.straight import follow
from workbench.planning.picking.propose import propose
from workbench.planning.picking.put_down import find_configurations_at_places
from workbench.planning.picking.resolve import resolve

TURNS = 48
"""Ways to turn a part that are tried at each point, drawn once for all cells."""

SHARES, ASIDE, HEIGHTS = (0.25, 0.5, 0.75, 1.0), (-0.1, 0.0, 0.1), (0.15, 0.25, 0.35)
"""Points: shares of the way from between the hands at home to the bin; [m] aside; [m] above it."""

MOST_WAYS = 3
"""Configurations of an arm at one pose of the part that are tried."""


class Got(IntEnum):
    """How far the best pair of grasps got; the last one is that it works."""

    NOT_LIFTED = 0
    NOT_PLACED = 1
    HANDS_MEET = 2
    NOT_REACHED = 3
    IN_SOMETHING = 4
    NO_STRAIGHT_WAY = 5
    OK = 6


WORDS = {
    Got.NOT_LIFTED: "no hand lifts it out of the bin",
    Got.NOT_PLACED: "no grasp of the other hand brings it to its place",
    Got.HANDS_MEET: "two hands that hold it meet",
    Got.NOT_REACHED: "no pose in the air that both arms reach",
    Got.IN_SOMETHING: "too near to something wherever both arms reach it",
    Got.NO_STRAIGHT_WAY: "no linear motion of the hands to it and away",
    Got.OK: "ok",
}


@dataclass(frozen=True, slots=True, eq=False)
class Hold:
    """A hand on the part: `away` (3,) [m], in the TCP's frame, is how the open hand leaves it."""

    arm: Arm
    grasp: Grasp
    T_tcp_part: pin.SE3
    away: Floats


class Exchanges:
    """The search for one pile: its parts where they lie, each asked as if it was taken next."""

    def __init__(self, cell: Cell, pile: tuple[Detection, ...], seed: int) -> None:
        self._cell, self._pile, self._seed = cell, pile, seed
        self._world = World(cell, pile)
        chains = self._world.chains
        homes = {arm.name: chains[arm.name].pose(np.asarray(arm.home)) for arm in cell.arms}
        self._homes = [T.translation for T in homes.values()]
        # The tool's place is where the hand is at home: what is asked is the lift alone.
        self._lifting = replace(
            cell,
            arms=tuple(
                replace(arm, part_places=(), Ts_world_place=(homes[arm.name],)) for arm in cell.arms
            ),
        )

    @cached_property
    def _lifted(self) -> dict[int, list[Hold]]:
        """By which holds each part is lifted; of a hand with two fingers turned by half, too."""
        world = World(self._lifting, self._pile)
        found: dict[int, list[Hold]] = {}
        for candidate in propose(world):
            pick = resolve(world, candidate, seed=self._seed)
            if isinstance(pick, Pick):
                grasp, arm = candidate.grasp, self._cell.arm(candidate.arm)
                T_part_tcp = self._pile[candidate.detection].T_world_part.actInv(
                    candidate.T_world_tcp
                )
                found.setdefault(candidate.detection, []).extend(
                    _hold(arm, grasp, T_part_tcp, pick.T_tcp_part.inverse() * T_turn)
                    for T_turn in hand_turns(arm.tool)
                )
        return found

    def _placing(self, number: int) -> Iterator[Hold]:
        """The holds by which a part, once it is in the hand, can be brought to a place for it."""
        kind = self._pile[number].part
        for arm, grasp in product(self._cell.arms, self._cell.part(kind).grasps):
            if not grasp.is_enabled or (grasp.arms and arm.name not in grasp.arms):
                continue
            starts = starts_of(self._world.chains[arm.name], arm, self._seed)
            for T_grip in grips(arm.tool, grasp):
                hold = _hold(arm, grasp, grasp.T_part_tcp, grasp.T_part_tcp * T_grip)
                phase = _bringing(number, hold)
                if (
                    arm.places_for(kind)
                    and find_configurations_at_places(self._world, arm, phase, starts).near
                ):
                    yield hold

    def try_exchange(self, number: int) -> Got:
        """Whether a part could be handed over in the air, or how far that got."""
        firsts = self._lifted.get(number, [])
        if not firsts:
            return Got.NOT_LIFTED
        seconds = list(self._placing(number))
        best = Got.NOT_PLACED
        for first in firsts:
            others = [later for later in seconds if later.arm.name != first.arm.name]
            if not others:
                continue
            held = [(T, q) for T in self._poses() for q in self._solve_hold(number, first, T)]
            for second in others:
                best = max(best, self._exchange(number, first, second, held))
                if best is Got.OK:
                    return best
        return best

    def _poses(self) -> Iterator[pin.SE3]:
        """Poses `T_world_part` in the air that are tried."""
        rng = np.random.default_rng(0)
        quaternions = [pin.Quaternion(q / np.linalg.norm(q)) for q in rng.normal(size=(TURNS, 4))]
        middle, bin = np.mean(self._homes, axis=0), self._cell.bin.T_world_bin
        sideways = self._homes[-1] - self._homes[0]
        sideways = sideways / np.linalg.norm(sideways)
        for quaternion, share, aside, height in product(quaternions, SHARES, ASIDE, HEIGHTS):
            point = middle + share * (bin.translation - middle) + aside * sideways
            point[2] = bin.translation[2] + height
            yield pin.SE3(quaternion.matrix(), point)

    def _ways(self, hold: Hold, T_world_part: pin.SE3) -> Floats:
        """Configurations (k, n) [rad] in which a hand has the part there, each once."""
        chain = self._world.chains[hold.arm.name]
        starts = starts_of(chain, hold.arm, self._seed)
        answers, residuals = chain.solve(T_world_part * hold.T_tcp_part.inverse(), starts)
        found = self._world.motion.rounded(answers[is_solution(residuals)])
        return found[np.sort(np.unique(found.round(2), axis=0, return_index=True)[1])]

    def _solve_hold(self, number: int, hold: Hold, T_world_part: pin.SE3) -> list[Floats]:
        """Configurations (n,) [rad] in which a hand has the part there, clear of everything."""
        name = hold.arm.name
        self._world.enter(_bringing(number, hold))
        return [
            q
            for q in self._ways(hold, T_world_part)
            if self._world.contact(self._world.configuration({name: q})) is None
        ][:MOST_WAYS]

    def _exchange(
        self, number: int, first: Hold, second: Hold, held: Sequence[tuple[pin.SE3, Floats]]
    ) -> Got:
        """How far an exchange between two holds got, of all poses at which the first one has it."""
        hands = (_labels(first.arm), _labels(second.arm))
        best = Got.NOT_REACHED
        for T_world_part, q_first in held:
            for q_second in self._ways(second, T_world_part)[:MOST_WAYS]:
                base = self._world.configuration(
                    {first.arm.name: q_first, second.arm.name: q_second}
                )
                self._world.enter(_coming(number, second, first))
                contact = self._world.contact(base)
                if contact is not None:
                    first_body, second_body = contact.pair
                    if any(first_body in hands[k] and second_body in hands[1 - k] for k in (0, 1)):
                        # Where both hold the part, they stand to each other as they always do.
                        return Got.HANDS_MEET
                    best = max(best, Got.IN_SOMETHING)
                    continue
                if self._comes(number, second, first, q_second, base, True) and self._comes(
                    number, first, second, q_first, base, False
                ):
                    return Got.OK
                best = Got.NO_STRAIGHT_WAY
        return best

    def _comes(
        self, number: int, moves: Hold, stands: Hold, q: Floats, base: Floats, closes: bool
    ) -> bool:
        """Whether an open hand comes straight to the part that the other one has, or leaves it.

        The way is the same, there and back.
        """
        world, name = self._world, moves.arm.name
        chain, columns = world.chains[name], world.kinematics.columns[name]
        T_world_tcp = chain.pose(q)
        T_away = T_world_tcp * pin.SE3(np.eye(3), moves.away)
        path, share = follow(chain, q, T_away, world.policy.straight_points)
        if share < 1.0:
            return False
        path = world.motion.rounded(path)
        world.enter(_coming(number, moves, stands))
        if path_contact(world, columns, base, path[::-1] if closes else path) is not None:
            return False
        world.enter(replace(_coming(number, moves, stands), targets={}, straight=frozenset()))
        clear = base.copy()
        clear[columns] = path[-1]
        return world.contact(clear) is None


def _hold(arm: Arm, grasp: Grasp, T_part_authored: pin.SE3, T_part_tcp: pin.SE3) -> Hold:
    """A hand that is turned against the grasp as it is authored, whose approach it keeps."""
    approach = T_part_authored.rotation @ grasp.approach
    away = -grasp.approach_length * (T_part_tcp.rotation.T @ approach)
    return Hold(arm, grasp, T_part_tcp.inverse(), away)


def _bringing(number: int, moves: Hold) -> LegPhase:
    """A hand that moves with the part."""
    return LegPhase(
        moving=frozenset({moves.arm.name}),
        openings={moves.arm.name: moves.grasp.grip},
        held={moves.arm.name: (number, moves.T_tcp_part)},
    )


def _coming(number: int, moves: Hold, stands: Hold) -> LegPhase:
    """An open hand about to take the part that the other hand has, or just off it."""
    return LegPhase(
        moving=frozenset({moves.arm.name}),
        openings={moves.arm.name: moves.grasp.opening, stands.arm.name: stands.grasp.grip},
        held={stands.arm.name: (number, stands.T_tcp_part)},
        targets={moves.arm.name: number},
        straight=frozenset({moves.arm.name}),
    )


def _labels(arm: Arm) -> set[str]:
    """What the bodies of an arm's hand are called."""
    fingers = [finger.solid.name for finger in arm.tool.fingers]
    return {f"{arm.name} {name}" for name in (*fingers, *(b.name for b in arm.tool.body))}
