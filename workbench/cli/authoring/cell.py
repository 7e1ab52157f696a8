"""`workbench cell show` and `schema`: what a cell is made of, and what may stand in its file."""

from dataclasses import fields

from workbench.cli.arguments.cell import CellSchema, CellShow
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import print_table
from workbench.formats.cells.reading import read_cell
from workbench.formats.cells.schema import schema_text
from workbench.model.geometry import Floats, finest


def print_schema(typed: CellSchema) -> int:
    """Print the schema of cell files."""
    print(schema_text(), end="")
    return SUCCESS


def show_cell(typed: CellShow) -> int:
    """Print names and values."""
    cell = read_cell(typed.cell)
    bin, scanner, policy = cell.bin, cell.scanner, cell.policy
    inside = "inside" if bin.has_walls else "above a surface without walls"
    rows = [("digest", cell.digest)]
    rows += [
        (
            f"{arm.name} arm",
            f"{len(arm.joints)} axes to {arm.flange}, tool {arm.tool.name}, "
            f"{len(arm.Ts_world_place) + len(arm.part_places)} places",
        )
        for arm in cell.arms
    ]
    rows += [
        (
            f"part {part.name}",
            f"{part.mass * 1000:.0f} g, {len(part.library.grasps)} grasps, "
            f"{len(finest(part.pieces))} pieces",
        )
        for part in cell.parts
    ]
    rows += [
        ("bin", f"{_mm(bin.size)} mm {inside}, at {_mm(bin.T_world_bin.translation)} mm"),
        *(
            (
                f"region {region.name}",
                f"{_mm(region.size)} mm, at {_mm(region.T_bin_region.translation)} mm",
            )
            for region in bin.regions
        ),
        *(
            (f"fixture {fixture.name}", f"{len(fixture.solids)} solids")
            for fixture in cell.fixtures
        ),
        (
            "scanner",
            f"{scanner.resolution[0]} x {scanner.resolution[1]} pixels, at "
            f"{_mm(scanner.T_world_scanner.translation)} mm",
        ),
        (
            "controller",
            f"{cell.controller.link} at {cell.controller.host} port {cell.controller.port}",
        ),
        *(
            (
                f"policy {field.name}",
                f"{getattr(policy, field.name):.4g}"
                if isinstance(getattr(policy, field.name), float)
                else str(getattr(policy, field.name)),
            )
            for field in fields(policy)
        ),
    ]
    print_table(
        f"cell {cell.name} (lengths of the policy in m, angles in rad)", ("what", "value"), rows
    )
    return SUCCESS


def _mm(lengths: Floats) -> str:
    return ", ".join(f"{value * 1000:.0f}" for value in lengths)
