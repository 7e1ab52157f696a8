"""The seam of tools: grippers described by a few numbers instead of by their solids."""

from typing import Any, Protocol

from workbench.model.cell import Tool
from workbench.model.errors import InputError
from workbench.plugins.found import Group, load
from workbench.plugins.options import Options, options_of

ENTRY_POINTS: Group = "workbench.tools"


class ToolKind(Protocol):
    """A make of gripper.

    A class with this interface.  `Options` is the dataclass of the keys under `[tool.options]` in
    the cell file (`plugins.options`).  There lengths are in mm and angles in degrees, as everywhere
    in cell files.
    """

    Options: type

    def make(self, name: str, options: Any) -> Tool:
        """The gripper with these options.

        Solids are in the flange's frame; `T_flange_tcp` lies between the finger tips, or at the
        lip of a suction cup, with z pointing out of the tool.  Fingers are as when closed.

        Args:
            name: of the tool in this cell.
            options: an `Options`, checked.

        Raises:
            InputError: these options do not go together.
        """
        ...


def made_tool(kind: str, name: str, given: Options) -> Tool:
    """A tool of a kind, made of the options that a cell file gives.

    Raises:
        InputError: there is no such kind, its options are not right, or it makes no tool.
    """
    found: Any = load(ENTRY_POINTS, kind)
    tool = found().make(name, options_of(found.Options, given))
    if not isinstance(tool, Tool) or tool.name != name:
        raise InputError(f"the tool kind {kind!r} has not made a tool {name!r}")
    if not tool.body and not tool.fingers:
        raise InputError(f"the tool kind {kind!r} has made a tool without body and fingers")
    return tool
