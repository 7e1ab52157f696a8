"""What `workbench cell new` says of the cell that it has made."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from workbench.cli.terminal import print_json, print_table
from workbench.model.cell import Cell


@dataclass(frozen=True, slots=True, eq=False)
class Made:
    """A cell that was made: its file, what was left out, and what a person has to decide.

    `excess` [m] is by how much the convex pieces of links are larger than their meshes; `unchecked`
    are pairs of links that need no check, each with its reason.
    """

    path: Path
    cell: Cell
    gone: tuple[str, ...]
    excess: Mapping[str, float]
    unchecked: Mapping[tuple[str, str], str]
    decisions: Sequence[str]


def print_report(made: Made, *, as_json: bool) -> None:
    """Print tables and, last, the list of what a person has to decide; or JSON."""
    cell = made.cell
    if as_json:
        print_json(
            {
                "file": str(made.path),
                "arms": [{"arm": arm.name, "flange": arm.flange} for arm in cell.arms],
                "left_out": list(made.gone),
                "excess_mm": {link: round(e * 1000, 1) for link, e in made.excess.items()},
                "unchecked": [[*pair, why] for pair, why in sorted(made.unchecked.items())],
                "to_decide": list(made.decisions),
            }
        )
        return
    counts = {link.name: len(link.collision) for link in cell.robot.links}
    print_table(
        "What is checked in place of the meshes",
        ("link", "convex pieces", "larger than the mesh by at most mm"),
        [(link, str(counts[link]), f"{e * 1000:.1f}") for link, e in made.excess.items()],
    )
    print_table(
        "Pairs of links that are not checked",
        ("link", "link", "why"),
        [(*pair, why) for pair, why in sorted(made.unchecked.items())],
    )
    for arm in cell.arms:
        print(f"{arm.name} arm: {len(arm.joints)} joints to {arm.flange}, tool {arm.tool.name}")
    if made.gone:
        print(f"left out, as they hang on a flange: {', '.join(made.gone)}")
    print("To decide, where it is not as chosen here:")
    for number, decision in enumerate(made.decisions, start=1):
        print(f"{number}. {decision}")
    check = f"workbench cell check {made.path.parent} --picture tool.html"
    print(f"{made.path}: written. Check it, and see how the tool stands: {check}")
