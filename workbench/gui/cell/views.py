"""What the page says about the cell itself, as HTML; see `views` for how."""

from html import escape

from workbench.app.core.state import State, counted
from workbench.gui.scene.marks import measured_text
from workbench.gui.shared.look import NO_REACH, UNKNOWN_REACH, Jogged
from workbench.gui.shared.views import line, mm
from workbench.model.cell import Cell
from workbench.model.geometry import Floats, finest
from workbench.model.robot import Link

MOST_CONTACTS = 8


def cell_line(state: State) -> str:
    """Whether the cell is as in its file, and what is wrong with the file."""
    if state.cell_problem:
        return line(f"The cell file cannot be used: {state.cell_problem}", kind="bad")
    if state.saved != state.cell.digest:
        changes = counted(len(state.before), "change")
        return line(f"Changed and not saved; {changes} can be undone.")
    return line(f"As in its file; digest {state.cell.digest[:12]}.", kind="hint")


def tree_html(cell: Cell) -> str:
    """What the cell is made of, to be unfolded."""
    arms = [
        _branch(
            f"{arm.name} arm, {len(arm.joints)} axes to {arm.flange}",
            [
                f"carries {arm.tool.name}"
                + (f", can carry {', '.join(t.name for t in arm.tools)}" if arm.tools[1:] else ""),
                f"{len(arm.Ts_world_place) + len(arm.part_places)} places"
                + (", parts stay there" if arm.keeps_parts else ""),
                *(f"axis {k + 1} is {arm.joints[j]}" for k, j in enumerate(arm.axis_order)),
            ],
        )
        for arm in cell.arms
    ]
    parts = [
        _branch(
            f"part {part.name}, {part.mass * 1000:g} g",
            [
                f"{len(part.library.grasps)} grasps",
                f"{len(finest(part.pieces))} convex pieces",
                f"{len(part.mesh.triangles)} triangles",
            ],
        )
        for part in cell.parts
    ]
    fixtures = _branch(
        f"{len(cell.fixtures)} fixtures",
        [f"{fixture.name}, {len(fixture.solids)} solids" for fixture in cell.fixtures],
    )
    robot = _branch(
        f"robot {cell.robot.name}",
        [
            f"{len(cell.robot.links)} links, {sum(map(_solids, cell.robot.links))} shapes checked",
            f"{len(cell.robot.disabled_pairs)} pairs of links not checked",
        ],
    )
    length, width, height = (mm(float(size), 0) for size in cell.bin.size)
    regions = [f"region {region.name}" for region in cell.bin.regions]
    inside = f"{length} x {width} x {height} inside"
    if not cell.bin.has_walls:
        inside = f"{length} x {width} without walls, parts up to {height} high"
    scanner = f"scanner, {cell.scanner.source}"
    address = [cell.scanner.address] if cell.scanner.address else []
    where = f"{cell.controller.host} port {cell.controller.port}"
    rest = [
        _branch("bin", [inside, *regions]),
        _branch(scanner, [*address, "{} x {} pixels".format(*cell.scanner.resolution)]),
        _branch(f"controller, {cell.controller.link}", [where]),
    ]
    return f'<div class="wb-tree">{"".join([robot, *arms, *parts, fixtures, *rest])}</div>'


def _solids(link: Link) -> int:
    return len(link.collision)


def _branch(title: str, leaves: list[str]) -> str:
    items = "".join(f"<li>{escape(leaf)}</li>" for leaf in leaves)
    return f"<details><summary>{escape(title)}</summary><ul>{items}</ul></details>"


def measured_line(points: tuple[Floats, ...]) -> str:
    """The distance of two clicked points (3,) [m], or nothing."""
    if len(points) < 2:
        return ""
    return line(measured_text(*points).replace("\n", ": "))


def reach_line(arm: str, reached: tuple[Floats, Floats] | None) -> str:
    """What the colours of an arm's reach mean, or that it is worked out; nothing without an arm.

    Args:
        arm: whose reach is shown; empty for nobody's.
        reached: places (n, 3) [m] and the share (n,) of turns there, as far as they are known.
    """
    if not arm:
        return ""
    if reached is None or reached is NO_REACH:
        return line(f"Working out where the {arm} arm reaches …", kind="hint")
    if reached is UNKNOWN_REACH:
        text = f"Where the {arm} arm reaches could not be worked out; the log says why."
        return line(text, kind="bad")
    if not len(reached[0]):
        return line(f"The {arm} arm reaches nowhere with its tool straight down.", kind="warn")
    return line("Green: the tool can point straight down at any turn there; orange: at some.")


def contacts_html(jogged: Jogged | None) -> str:
    """What the jogged robot meets, nearest first, or how much room it has."""
    if jogged is None:
        return line("Moves the robot on the page only; nothing is sent to it.", kind="hint")
    if not jogged.contacts:
        if jogged.pair is None:
            return line("Clear of everything by more than 100 mm.")
        first, second = jogged.pair
        return line(f"Clear; nearest are {first} and {second}, {mm(jogged.clearance)}.")
    rows = "".join(
        f"<tr><td>{escape(contact.pair[0])}</td><td>{escape(contact.pair[1])}</td>"
        f'<td class="wb-number">{escape(_distance(contact.distance))}</td></tr>'
        for contact in jogged.contacts[:MOST_CONTACTS]
    )
    more = len(jogged.contacts) - MOST_CONTACTS
    rest = line(f"and {more} more", kind="hint") if more > 0 else ""
    return (
        '<table class="wb-facts wb-contacts"><thead><tr><th>Too close</th><th></th>'
        f'<th class="wb-number">Distance</th></tr></thead><tbody>{rows}</tbody></table>{rest}'
    )


def _distance(metres: float) -> str:
    return f"{mm(-metres)} inside" if metres < 0 else mm(metres)
