"""From drawings to a tool that an arm can carry: made, and checked on the arm."""

from workbench.app.core.cell.making import carrying
from workbench.formats.cells.drawn_tools import DrawnTool, made_of
from workbench.model.cell import Cell, Tool
from workbench.model.errors import InputError, JobCancelled
from workbench.model.messages.message import Message
from workbench.model.messages.parts import DrawnText
from workbench.model.messages.work import CancelText, ProgressText
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.plugins.progress import Cancelled, Report


def tool_for(cell: Cell, arm: str, drawn: DrawnTool, report: Report, cancelled: Cancelled) -> Tool:
    """The tool that is described, for an arm of the cell; nothing is written.

    Raises:
        JobCancelled: a person has ended it.
        InputError: a drawing cannot be used, or the tool reaches into the robot at home.
    """

    def go_on(done: float, note: Message | str) -> None:
        if cancelled():
            raise JobCancelled(CancelText.TOOL())
        report(0.8 * done, note)

    tool = made_of(drawn, go_on)
    go_on(1.0, ProgressText.MEETS_ROBOT())
    if met := met_at_home(carrying(cell, arm, tool), arm):
        raise InputError(DrawnText.MEETS(tool=tool.name, body=met))
    return tool


def met_at_home(cell: Cell, arm: str) -> str:
    """The link with which an arm's tool collides, with all arms at home; empty: none.

    The fingers are checked closed and fully open.
    """
    tool, world = cell.arm(arm).tool, World(cell, ())
    solids = (*tool.body, *(finger.solid for finger in tool.fingers))
    labels = {f"{arm} {solid.name}" for solid in solids}
    links = {link.name for link in cell.robot.links}
    at_home = world.configuration({})
    for opening in tool.stroke:
        world.enter(LegPhase(frozenset({arm}), {arm: opening}))
        for contact in world.contacts(at_home):
            met = set(contact.pair) & links
            if contact.distance <= 0.0 and met and labels & set(contact.pair):
                return met.pop()
    return ""
