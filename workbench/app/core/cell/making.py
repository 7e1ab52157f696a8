"""Parts of CAD files and tools of drawings: made by a task, and then in the cell."""

from dataclasses import dataclass, field, replace
from pathlib import PurePosixPath
from typing import ClassVar

import numpy as np

from workbench.app.core.cell.changes import Changed, changed_cell
from workbench.app.core.command import SAFE, Asked, Command, Decision, Entry, Right, refuse_input
from workbench.app.core.people import Role
from workbench.app.core.state import State
from workbench.app.core.tasks import begin_task
from workbench.app.core.value_checks import check_among, check_number, check_text
from workbench.formats.cells.drawn_tools import Bytes, DrawnTool, check_drawn
from workbench.formats.files.units import UNITS
from workbench.formats.files.whole_files import MB
from workbench.formats.meshes.cad_files import CAD_ENDINGS, LARGEST_CAD
from workbench.formats.parts.new_part import check_name
from workbench.model.cell import Arm, Cell, Tool
from workbench.model.digest import LATER
from workbench.model.errors import CommandRefused
from workbench.model.geometry import frozen, put
from workbench.model.messages.commands import CommandText
from workbench.model.messages.refusals import ChangeRefusal
from workbench.model.messages.states import StateText
from workbench.model.part import Part

DENSITIES = (10.0, 25_000.0)
"""[kg/m3] From foam to more than gold."""


MOST_KINDS = 20
"""Parts of one cell: each is searched for in every scan."""


MOST_TOOLS = 20
"""That one arm can carry."""


LONGEST_SOLID = 300
"""Letters of the name of a solid in a CAD file."""


@dataclass(frozen=True, slots=True, eq=False)
class ImportPart(Command):
    """Make a part of a CAD file, and have the cell pick it too.

    `content` (n,) are the bytes of `file`; `unit` mm, m, inch, or empty when the file or its size
    says it; `density` [kg/m3] makes the mass; `is_mended`: close what is open; `is_symmetric`:
    state its symmetry; `solid`: which of several, empty for all as one rigid part.
    """

    right: ClassVar[Right] = Right(
        CommandText.IMPORT_PART, SAFE, role=Role.ENGINEER, changes_cell=True
    )

    name: str
    file: str
    content: Bytes
    unit: str = ""
    density: float = 1200.0
    is_mended: bool = False
    is_symmetric: bool = False
    solid: str = field(default_factory=str, metadata=LATER)

    def __post_init__(self) -> None:
        put(self, content=frozen(self.content, np.uint8))

    def check(self, state: State, asked: Asked) -> None:
        check_import(state.cell, self)

    def apply(self, state: State, entry: Entry) -> Decision:
        says = StateText.MAKING_PART(part=self.name, file=self.file)
        return begin_task(state, entry, "import", {"command": self}, says)


@dataclass(frozen=True, slots=True, eq=False)
class AddTool(Command):
    """Make a tool of drawings, and have the arm of that name carry it."""

    right: ClassVar[Right] = Right(
        CommandText.ADD_TOOL, SAFE, role=Role.ENGINEER, changes_cell=True
    )

    arm: str
    drawn: DrawnTool

    def check(self, state: State, asked: Asked) -> None:
        check_tool(state.cell, self)

    def apply(self, state: State, entry: Entry) -> Decision:
        says = StateText.MAKING_TOOL(tool=self.drawn.name, file=self.drawn.body.file)
        arguments = {"arm": self.arm, "drawn": self.drawn}
        return begin_task(state, entry, "tool", arguments, says, arm=self.arm)


def with_made(state: State, number: int, made: Part | Tool) -> Changed:
    """The state with a part or a tool that a task has made, as long as it was still wanted."""
    job = state.job
    wanted = "import" if isinstance(made, Part) else "tool"
    if job is None or job.number != number or job.name != wanted:
        return state, ()
    state = replace(state, job=None)
    if isinstance(made, Part):
        cell = replace(state.cell, parts=(*state.cell.parts, made))
        size = made.facts["mm"]
        says = StateText.PART_MADE(part=made.name, size=str(size))
    else:
        cell = carrying(state.cell, job.arm, made)
        says = StateText.TOOL_MADE(arm=job.arm, tool=made.name)
    return changed_cell(state, cell, says)


def carrying(cell: Cell, arm: str, tool: Tool) -> Cell:
    """The cell with one more tool for an arm, which carries it now."""

    def add_tool(changed_arm: Arm) -> Arm:
        return replace(
            changed_arm, tool=tool, tools=(*(changed_arm.tools or (changed_arm.tool,)), tool)
        )

    return replace(
        cell,
        arms=tuple(add_tool(any_arm) if any_arm.name == arm else any_arm for any_arm in cell.arms),
    )


def check_import(cell: Cell, command: ImportPart) -> None:
    """A part of this name can be made of such a file.

    Raises:
        CommandRefused: it cannot.
    """
    check_text("file", command.file)
    with refuse_input():
        check_name(command.name)
    if command.name in (part.name for part in cell.parts):
        raise CommandRefused(ChangeRefusal.PART_EXISTS(part=command.name))
    if len(cell.parts) >= MOST_KINDS:
        raise CommandRefused(ChangeRefusal.MOST_PARTS(most=MOST_KINDS))
    kind = PurePosixPath(command.file).suffix.lower()
    if kind not in CAD_ENDINGS:
        raise CommandRefused(ChangeRefusal.NO_CAD(file=command.file, kinds=CAD_ENDINGS))
    if not 0 < command.content.size <= LARGEST_CAD:
        raise CommandRefused(
            ChangeRefusal.FILE_SIZE(
                file=command.file, bytes=f"{command.content.size:,}", most=f"{LARGEST_CAD / MB:g}"
            )
        )
    if len(command.solid) > LONGEST_SOLID:
        raise CommandRefused(ChangeRefusal.SOLID_NAME(most=LONGEST_SOLID))
    check_among("unit", command.unit, ("", *UNITS))
    check_number("density", command.density, *DENSITIES, "kg/m3")


def check_tool(cell: Cell, command: AddTool) -> None:
    """The drawing makes a tool, and the arm that shall carry it has room for it.

    Raises:
        CommandRefused: it cannot, or has none.
    """
    name = command.drawn.name
    check_among("arm", command.arm, tuple(arm.name for arm in cell.arms))
    with refuse_input():
        check_drawn(command.drawn)
    known = {tool.name for arm in cell.arms for tool in (arm.tool, *arm.tools)}
    if name in known:
        raise CommandRefused(ChangeRefusal.TOOL_EXISTS(tool=name))
    if len(cell.arm(command.arm).tools) >= MOST_TOOLS:
        raise CommandRefused(ChangeRefusal.MOST_TOOLS(most=MOST_TOOLS))
