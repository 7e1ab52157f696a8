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


def is_to_view(result: Any) -> bool:
    """Whether the plan of a planning, in canonical form, takes a scanner to its view."""
    plan = result["plan"]
    return plan is not None and all(arm["detection"] == NO_PART for arm in plan["arms"])


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
