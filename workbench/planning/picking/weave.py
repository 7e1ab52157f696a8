"""The legs of two arms in the order that takes the least time, at once where they can.

Each step of a plan is a leg of one arm, while the other stands where its last leg has ended; or a
leg of both.  So an order is a path over a grid of how many legs of each arm are done.  The quickest
path whose steps are all possible is taken; both arms move at once only where they cannot meet at
any speeds.  Checks take the time: only the steps of the quickest path are checked, then, if one is
impossible, those of the next path.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from workbench.model.motion import LEG_NAMES
from workbench.model.plan import ArmPlan, Guarantee, Plan, Step, Strategy
from workbench.planning.collision.world import World
from workbench.planning.picking.dual_arm import CARRYING, ArmTask, find_arm_contact, passes

COUNT = len(LEG_NAMES)

HOMEWARD = LEG_NAMES.index("home")
"""In turns, the second arm may set out while the first goes home."""

WON = 0.001
"""[s] Smallest reduction of the cycle time that counts."""


@dataclass(frozen=True, slots=True)
class Move:
    """One step: how many legs each arm has done before, and who moves.

    `is_sequential`: the second arm starts no earlier than the home leg of the first.
    """

    done: tuple[int, int]
    moves: tuple[bool, bool]

    @property
    def after(self) -> tuple[int, int]:
        """How many legs each arm has done after the step."""
        return self.done[0] + self.moves[0], self.done[1] + self.moves[1]

    @property
    def is_sequential(self) -> bool:
        """Whether plans have it whose second arm starts no earlier than the first goes home."""
        alone = (self.done[1] == 0, self.done[0] == COUNT)
        return self.done == (HOMEWARD, 0) if all(self.moves) else alone[self.moves[1]]

    @property
    def keeps_order(self) -> bool:
        """Whether the second arm has done no more legs than the first."""
        return self.after[0] >= self.after[1]


ALL_MOVES = tuple(
    Move((first, second), moves)
    for first in range(COUNT, -1, -1)
    for second in range(COUNT, -1, -1)
    for moves in ((True, True), (True, False), (False, True))
    if first + moves[0] <= COUNT and second + moves[1] <= COUNT
)
"""All possible steps, the last first; both arms at once before one of them."""


@dataclass(slots=True)
class Weave:
    """Two arms with their legs in a world, and what is known of the steps they could do.

    Concurrency: one thread.
    """

    world: World
    arms: tuple[ArmPlan, ArmPlan]
    possible: dict[Move, bool] = field(default_factory=dict[Move, bool])

    def quickest(self, among: Sequence[Move]) -> tuple[Move, ...] | None:
        """The quickest order of possible steps, all of them of `among`; None when there is none."""
        known = self.possible
        left = [(m, m.after, self.seconds((m,))) for m in among if known.get(m, True)]
        while (moves := _quickest(left)) is not None:
            refused = next((move for move in moves if not self.is_possible(move)), None)
            if refused is None:
                return moves
            left = [option for option in left if option[0] is not refused]
        return None

    def seconds(self, moves: Sequence[Move]) -> float:
        """What steps take one after the other [s]."""
        return sum(
            max(self.arms[k].legs[move.done[k]].seconds for k in (0, 1) if move.moves[k])
            for move in moves
        )

    def is_possible(self, move: Move) -> bool:
        """Whether nothing meets in that step; it is checked once."""
        if move not in self.possible:
            tasks = [
                ArmTask(arm, LEG_NAMES[done]) if moves else None
                for arm, done, moves in zip(self.arms, move.done, move.moves, strict=True)
            ]
            if tasks[0] and tasks[1]:
                self.possible[move] = find_arm_contact(self.world, (tasks[0], tasks[1])) is None
            else:
                waits = 1 if tasks[0] else 0
                moving = tasks[1 - waits]
                assert moving is not None
                self.possible[move] = passes(self.world, moving, self.arms[waits], move.done[waits])
        return self.possible[move]


def _quickest(
    steps: Sequence[tuple[Move, tuple[int, int], float]],
) -> tuple[Move, ...] | None:
    """The quickest order of steps, given with where each leads and what it takes [s]."""
    best: dict[tuple[int, int], tuple[float, Move | None]] = {(COUNT, COUNT): (0.0, None)}
    for move, after, seconds in steps:
        if after in best:
            seconds += best[after][0]
            if move.done not in best or seconds < best[move.done][0]:
                best[move.done] = seconds, move
    at, moves = (0, 0), list[Move]()
    while at in best and (move := best[at][1]) is not None:
        moves.append(move)
        at = move.after
    return tuple(moves) or None


def interleave(world: World, plan: Plan, *, freely: bool) -> tuple[Plan, ...]:
    """Plans in which the arms of a plan wait less for each other, the quickest first.

    Args:
        world: of the cell and the detections that the plan was made for.
        plan: for two arms, one after the other.
        freely: any legs may run at once, and until the second arm carries its part its legs were
            planned as if the first had placed nothing; otherwise the second arm sets out while the
            first goes home, and no earlier.

    Returns:
        Plans that no proof has seen yet, and the given one last where its steps are possible; that
        alone where nothing is won.
    """
    first, second = plan.arms
    in_turn = tuple(move for move in ALL_MOVES if move.is_sequential)
    own = [move for move in in_turn if not all(move.moves)]
    planned = [m for m in own if not (freely and m.moves[1] and m.done[1] < CARRYING)]
    weave = Weave(world, (first, second), dict.fromkeys(planned, True))
    ways = [weave.quickest(in_turn)]
    if freely:
        has_pairs = any(part.library.pairs for part in world.cell.parts)
        ways.insert(
            0, weave.quickest(tuple(m for m in ALL_MOVES if m.keeps_order or not has_pairs))
        )
    found = [plan] if all(map(weave.is_possible, own)) else []
    for moves in reversed(ways):
        if moves and (not found or weave.seconds(moves) < found[0].cycle_seconds - WON):
            found.insert(0, _plan_of(plan, moves))
    return tuple(found)


def _plan_of(plan: Plan, moves: tuple[Move, ...]) -> Plan:
    """A plan with its legs in another order."""
    steps = tuple(
        Step(
            tuple(
                (arm.arm, LEG_NAMES[done])
                for arm, done, is_moved in zip(plan.arms, move.done, move.moves, strict=True)
                if is_moved
            )
        )
        for move in moves
    )
    is_sequential = all(move.is_sequential for move in moves)
    return replace(
        plan,
        sequence=steps,
        strategy=Strategy.ALTERNATED if is_sequential else Strategy.COORDINATED,
        guarantee=Guarantee.TIME_INDEPENDENT,
    )
