"""What no grasp of the tool can take: searched for among all of them, however they are authored.

It states whether more grasps would help.  A linear motion in along the tool, a straight lift of the
policy and a place are asked for as of every pick; pushing parts about is not checked.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.model.candidate import Pick, Reason
from workbench.model.cell import Cell
from workbench.model.derived.by_tcp import by_each_tcp, by_taking
from workbench.model.messages.message import Message
from workbench.model.messages.parts import PileText
from workbench.model.messages.states import LeftText
from workbench.model.scan import Detection
from workbench.perception.simulation.unloading import is_in_bin, unloaded
from workbench.planning.collision.world import World
from workbench.planning.grasps.grip_raster import clear_grips, grips_of
from workbench.planning.kinematics.chain import chain_of
from workbench.planning.picking.lifts import find_lifts_clear_for_part
from workbench.planning.picking.propose import candidate_of
from workbench.planning.picking.resolve import resolve

MOST_CHECKED_GRIPS = 200
"""Grips that fit and hold whose arm is checked, spread over all of them."""


HELD = 20
"""Grips that fit at a part and are checked whether they hold, for an estimate."""


@dataclass(frozen=True, slots=True, eq=False)
class AnyGrasp:
    """Whether any grasp of a cell's tools takes a part: `pick` does, None where none was found.

    Of `tried` grips `fits` meet nothing but the part, and `holds` of these hold it; `refused`
    counts why the arms cannot take it by those that were checked.
    """

    tried: int
    fits: int
    holds: int
    refused: tuple[tuple[Reason, int], ...]
    pick: Pick | None

    @property
    def message(self) -> Message:
        """The result for people."""
        if self.pick is not None:
            candidate = self.pick.candidate
            at = candidate.grasp.T_part_tcp
            return PileText.ANY_GRASP(
                arm=candidate.arm,
                at=[f"{value:.0f}" for value in at.translation * 1e3],
                along=[f"{value:.2f}" for value in at.rotation[:, 2]],
                grip=candidate.grasp.grip,
            )
        counts = {"tried": self.tried, "fits": self.fits, "holds": self.holds}
        if not self.refused:
            return PileText.NO_GRASP_FOUND(**counts)
        reasons = [
            LeftText.COUNTED(count=count, reason=reason.message) for reason, count in self.refused
        ]
        return PileText.NO_GRASP_SINCE(**counts, reasons=reasons)


def any_grasp(cell: Cell, lying: Sequence[Detection], number: int, *, seed: int) -> AnyGrasp:
    """Look for any grasp by which some arm takes a part as it lies among the others."""
    detections = tuple(lying)
    part = cell.part(lying[number].part)
    tried = fits = holds = 0
    refused: Counter[Reason] = Counter()
    worlds = [World(each, detections) for each in by_each_tcp(cell)]
    for world, arm in [(each, arm) for each in worlds for arm in each.cell.arms]:
        grips, clear = grips_of(part, arm.tool), clear_grips(world.cell, part, arm)
        free = clear[world.tool_check.free(arm, number, grips.hands.some(clear))]
        found = [grasp for k in free.tolist() if (grasp := grips.grasp(k)) is not None]
        tried, fits, holds = tried + len(grips.hands.turn), fits + len(free), holds + len(found)
        order = np.random.default_rng(seed).permutation(len(found))[:MOST_CHECKED_GRIPS]
        for k in order.tolist():
            candidate = candidate_of(world, number, found[k], arm)
            result = resolve(world, candidate, seed=seed)
            if isinstance(result, Pick):
                return AnyGrasp(tried, fits, holds, tuple(refused.most_common()), result)
            refused[result.reason] += 1
    return AnyGrasp(tried, fits, holds, tuple(refused.most_common()), None)


def holdable(cell: Cell, lying: Sequence[Detection], *, seed: int) -> int:
    """How many parts some hand fits at and holds as they lie, and that can be lifted alone.

    An estimate of what a search by the arms, too, would find (`bound_of`), in a fraction of its
    time: whether an arm gets there is not asked, nor what comes free when others are gone.
    """
    worlds = [World(each, tuple(lying)) for each in by_each_tcp(cell)]
    rng = np.random.default_rng(seed)
    return sum(
        any(_is_holdable(world, number, rng) for world in worlds) for number in range(len(lying))
    )


def _is_holdable(world: World, number: int, rng: np.random.Generator) -> bool:
    part = world.cell.part(world.detections[number].part)
    seen: set[str] = set()
    for arm in world.cell.arms:
        if arm.tool.name in seen:
            continue
        seen.add(arm.tool.name)
        grips, clear = grips_of(part, arm.tool), clear_grips(world.cell, part, arm)
        free = clear[world.tool_check.free(arm, number, grips.hands.some(clear))]
        for k in rng.permutation(free)[:HELD].tolist():
            grasp = grips.grasp(k)
            if grasp is not None:
                candidate = candidate_of(world, number, grasp, arm)
                if find_lifts_clear_for_part(world, candidate, candidate.T_world_tcp)[1] is None:
                    return True
    return False


def bound_of(
    cell: Cell, lying: Sequence[Detection], *, settles: bool, seed: int
) -> tuple[tuple[AnyGrasp, ...], int]:
    """What any grasp could take of what is left.

    Args:
        cell: that it was tried in.
        lying: what is left.
        settles: whether the rest moves by physics as a part is lifted.
        seed: of everything random.

    Returns:
        For each part whether any grasp takes it as it lies now; and how many come out when they are
        taken one after the other, as far as it goes.
    """
    first = tuple(any_grasp(cell, lying, number, seed=seed) for number in range(len(lying)))
    rest, found, taken = tuple(lying), list(first), 0
    while rest:
        number = next((k for k, grasp in enumerate(found) if grasp.pick is not None), None)
        if number is None:
            break
        rest, taken = _without(cell, rest, number, found[number].pick, settles=settles), taken + 1
        found = []
        for k in range(len(rest)):
            found.append(any_grasp(cell, rest, k, seed=seed))
            if found[-1].pick is not None:
                break
    return first, taken


def _without(
    cell: Cell, lying: tuple[Detection, ...], number: int, pick: Pick | None, *, settles: bool
) -> tuple[Detection, ...]:
    assert pick is not None
    if not settles:
        return tuple(detection for k, detection in enumerate(lying) if k != number)
    chain = chain_of(cell, by_taking(cell, pick.candidate).arm(pick.candidate.arm))
    way = [chain.pose(q) * pick.T_tcp_part for q in np.asarray(pick.extract)]
    settled = unloaded(cell, lying, number, way)
    return tuple(
        detection
        for detection in settled
        if is_in_bin(cell.bin, cell.part(detection.part), detection.T_world_part)
    )
