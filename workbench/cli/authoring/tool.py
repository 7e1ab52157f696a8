"""`workbench cell tool`: an arm carries a gripper from its URDF or xacro."""

from workbench.app.core.cell.making import carrying
from workbench.app.picking.tool_making import met_at_home
from workbench.cli.arguments.cell import CellTool
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import check_number, split_option
from workbench.formats.cells.edits import save_cell
from workbench.formats.cells.reading import cell_path, read_cell
from workbench.formats.grippers.grippers import gripper_of, tool_name
from workbench.formats.parts.new_part import check_name
from workbench.formats.robots.descriptions import read_description
from workbench.model.errors import InputError


def add_tool(typed: CellTool) -> int:
    """Make the tool, look whether it stands free on the arms at home, and write it."""
    cell = read_cell(typed.cell)
    found = read_description(
        typed.gripper,
        arguments=dict(split_option("--xacro", argument, ":=") for argument in typed.xacro),
        package_paths=typed.package_path,
        mesh_unit=typed.mesh_unit,
    )
    name = typed.name or tool_name(found)
    check_name(name)
    widest = None
    if typed.widest_mm is not None:
        check_number("--widest-mm", typed.widest_mm, 1, 1000)
        widest = typed.widest_mm / 1000
    tool, notes = gripper_of(found, name, widest)
    if name in {known.name for arm in cell.arms for known in (arm.tool, *arm.tools)}:
        raise InputError(f"tool {name}: is there already; choose another --name")
    for arm in typed.arm or [arm.name for arm in cell.arms]:
        cell = carrying(cell, cell.arm(arm).name, tool)
        if met := met_at_home(cell, arm):
            raise InputError(
                f"tool {name} reaches into {met} while the {arm} arm is at home: its root link is "
                "put onto the flange, z out of the arm; another home_deg in the cell file may do"
            )
    path = cell_path(typed.cell)
    save_cell(path, cell)
    takes_by = "two fingers" if tool.fingers else "a lip"
    print(f"{path}: tool {name}, {len(tool.body)} solids and {takes_by}")
    for note in notes:
        print(f"- {note}")
    print("To decide: force_n and mass_g of the tool; grasps are for openings that it has")
    return SUCCESS
