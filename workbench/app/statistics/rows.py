"""Plans of a row as they are on record: which parts each of them takes."""

from collections.abc import Sequence
from typing import Any

from workbench.model.plan import NO_PART

Numbers = tuple[tuple[int, ...], ...]
"""For each plan of a row, the numbers that its parts had in the first."""


def numbers_of_row(result: Any) -> Numbers:
    """The numbers of the parts of each plan, from a planning in canonical form."""
    plan, *later = _plans(result)
    first = [detection["T_world_part"] for detection in plan["detections"]]
    return (
        tuple(range(len(first))),
        *(
            tuple(
                first.index(part.get("T_world_found", part["T_world_part"]))
                for part in later_plan["detections"]
            )
            for later_plan in later
        ),
    )


def takes_no_part(result: Any) -> bool:
    """Whether a planning, in canonical form, was for a scanner's path to its view, or to stir.

    Without a plan it shows by its candidates: it has none.
    """
    plan = result["plan"]
    if plan is None:
        return not result["candidates"]
    return all(arm["detection"] == NO_PART for arm in plan["arms"])


def picks_of_row(result: Any, numbers: Numbers) -> Sequence[Sequence[tuple[int, str, str, str]]]:
    """For each plan: number, part, grasp and arm of every pick."""
    return [
        [
            (
                plan_numbers[arm["detection"]],
                plan["detections"][arm["detection"]]["part"],
                arm["grasp"],
                arm["arm"],
            )
            for arm in plan["arms"]
        ]
        for plan, plan_numbers in zip(_plans(result), numbers, strict=True)
    ]


def _plans(result: Any) -> list[Any]:
    return [result["plan"], *(proven["plan"] for proven in result.get("row", ()))]
