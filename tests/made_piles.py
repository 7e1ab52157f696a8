"""Results of emptied piles, as tests make them up."""

from workbench.model.messages.message import plain
from workbench.model.prediction import EmptiedPile, LeftPart, PileTask


def scene(seed: int, taken: int, left: int, failed=(0, 0, 0)) -> EmptiedPile:
    stays = tuple(
        LeftPart(f"part-{k + 1}", "tool collision", plain("in the way"), "") for k in range(left)
    )
    return EmptiedPile(
        task=PileTask("yumi", "", taken + left, seed),
        parts=taken + left,
        taken=taken,
        failed=failed,
        touches=0,
        knocked_out=0,
        cycles=taken,
        scans=taken + 3,
        motion_seconds=10.0 * taken,
        left=stays,
        planning=(0.1, 0.3),
        stages=(("propose", 0.4),),
        finding=0.0,
    )
