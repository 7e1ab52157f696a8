"""What the page says about the cell itself, as HTML; see `views` for how."""

from collections.abc import Iterable
from html import escape

from workbench.app.core.state import State
from workbench.gui.scene.marks import measured_text
from workbench.gui.shared.look import NO_REACH, UNKNOWN_REACH, Jogged
from workbench.gui.shared.views import line
from workbench.gui.texts.cell import CellPageText
from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats, finest
from workbench.model.messages.message import Message, as_message
from workbench.model.robot import Link
from workbench.words.words import IN_ENGLISH, Words

MOST_CONTACTS = 8


def cell_line(state: State, words: Words = IN_ENGLISH) -> str:
    """Whether the cell is as in its file, and what is wrong with the file."""
    if state.cell_problem:
        refused = CellPageText.FILE_REFUSED(problem=as_message(state.cell_problem))
        return line(words.render(refused), kind="bad")
    if not state.is_saved:
        return line(words.render(CellPageText.CHANGED(count=len(state.before))))
    return line(words.render(CellPageText.AS_IN_FILE(digest=state.cell.digest[:12])), kind="hint")


def tree_html(cell: Cell, words: Words = IN_ENGLISH) -> str:
    """What the cell is made of, to be unfolded."""

    def branch(title: Message, leaves: Iterable[Message | str]) -> str:
        items = "".join(f"<li>{escape(words.render(leaf))}</li>" for leaf in leaves)
        return (
            f"<details><summary>{escape(words.render(title))}</summary><ul>{items}</ul></details>"
        )

    arms = [
        branch(
            CellPageText.ARM(arm=arm.name, axes=len(arm.joints), flange=arm.flange),
            (
                _carries(arm),
                (CellPageText.PLACES_KEEP if arm.keeps_parts else CellPageText.PLACES)(
                    count=len(arm.Ts_world_place) + len(arm.part_places)
                ),
                *(
                    CellPageText.AXIS_JOINT(number=number, joint=arm.joints[joint])
                    for number, joint in enumerate(arm.axis_order, 1)
                ),
            ),
        )
        for arm in cell.arms
    ]
    parts = [
        branch(
            CellPageText.PART(name=part.name, mass=part.mass),
            (
                CellPageText.GRASPS(count=len(part.library.grasps)),
                CellPageText.PIECES(count=len(finest(part.pieces))),
                CellPageText.TRIANGLES(count=len(part.mesh.triangles)),
            ),
        )
        for part in cell.parts
    ]
    fixtures = branch(
        CellPageText.FIXTURES(count=len(cell.fixtures)),
        (
            CellPageText.FIXTURE(name=fixture.name, count=len(fixture.solids))
            for fixture in cell.fixtures
        ),
    )
    shapes = sum(map(_solids, cell.robot.links))
    robot = branch(
        CellPageText.ROBOT(name=cell.robot.name),
        (
            CellPageText.LINKS(links=len(cell.robot.links), shapes=shapes),
            CellPageText.PAIRS(count=len(cell.robot.disabled_pairs)),
        ),
    )
    scanner, controller = cell.scanner, cell.controller
    columns, rows = scanner.resolution
    pixels = CellPageText.PIXELS(width=columns, height=rows)
    rest = [
        branch(CellPageText.BIN(), _bin(cell)),
        branch(
            CellPageText.SCANNER(source=scanner.source),
            (CellPageText.NAME(name=scanner.address), pixels) if scanner.address else (pixels,),
        ),
        branch(
            CellPageText.CONTROLLER(link=controller.link),
            (CellPageText.ADDRESS(host=controller.host, port=controller.port),),
        ),
    ]
    return f'<div class="wb-tree">{"".join([robot, *arms, *parts, fixtures, *rest])}</div>'


def _carries(arm: Arm) -> Message:
    """The tool of an arm, and those that it can change to."""
    if not arm.tools[1:]:
        return CellPageText.CARRIES(tool=arm.tool.name)
    return CellPageText.CAN_CARRY(tool=arm.tool.name, tools=[tool.name for tool in arm.tools])


def _bin(cell: Cell) -> tuple[Message, ...]:
    """The size of the bin, and its regions."""
    length, width, height = map(float, cell.bin.size)
    inside = CellPageText.INSIDE if cell.bin.has_walls else CellPageText.NO_WALLS
    regions = (CellPageText.REGION(name=region.name) for region in cell.bin.regions)
    return inside(length=length, width=width, height=height), *regions


def _solids(link: Link) -> int:
    return len(link.collision)


def measured_line(points: tuple[Floats, ...]) -> str:
    """The distance of two clicked points (3,) [m], or nothing."""
    if len(points) < 2:
        return ""
    return line(measured_text(*points).replace("\n", ": "))


def reach_line(arm: str, reached: tuple[Floats, Floats] | None, words: Words = IN_ENGLISH) -> str:
    """What the colours of an arm's reach mean, or that it is worked out; nothing without an arm.

    Args:
        arm: whose reach is shown; empty for nobody's.
        reached: places (n, 3) [m] and the share (n,) of turns there, as far as they are known.
        words: of who reads it.
    """
    if not arm:
        return ""
    if reached is None or reached is NO_REACH:
        return line(words.render(CellPageText.REACH_COMPUTING(arm=arm)), kind="hint")
    if reached is UNKNOWN_REACH:
        return line(words.render(CellPageText.REACH_FAILED(arm=arm)), kind="bad")
    if not len(reached[0]):
        return line(words.render(CellPageText.REACH_NOWHERE(arm=arm)), kind="warn")
    return line("Green: the tool can point straight down at any turn there; orange: at some.")


def contacts_html(jogged: Jogged | None, words: Words = IN_ENGLISH) -> str:
    """What the jogged robot meets, nearest first, or how much room it has."""
    if jogged is None:
        return line("Moves the robot on the page only; nothing is sent to it.", kind="hint")
    if not jogged.contacts:
        if jogged.pair is None:
            return line("Clear of everything by more than 100 mm.")
        first, second = jogged.pair
        nearest = CellPageText.NEAREST(first=first, second=second, clearance=jogged.clearance)
        return line(words.render(nearest))
    rows = "".join(
        f"<tr><td>{escape(contact.pair[0])}</td><td>{escape(contact.pair[1])}</td>"
        f'<td class="wb-number">{escape(words.render(_distance(contact.distance)))}</td></tr>'
        for contact in jogged.contacts[:MOST_CONTACTS]
    )
    more = len(jogged.contacts) - MOST_CONTACTS
    rest = line(words.render(CellPageText.MORE_PAIRS(count=more)), kind="hint") if more > 0 else ""
    return (
        '<table class="wb-facts wb-contacts"><thead><tr><th>Too close</th><th></th>'
        f'<th class="wb-number">Distance</th></tr></thead><tbody>{rows}</tbody></table>{rest}'
    )


def _distance(metres: float) -> Message:
    if metres < 0:
        return CellPageText.PENETRATION(depth=-metres)
    return CellPageText.DISTANCE(distance=metres)
