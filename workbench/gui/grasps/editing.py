"""What one browser edits: which part, which of its grasps, with which tool; no controls."""

import threading
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeVar

import pinocchio as pin

from workbench.app.core.cell.part_edits import EditPart
from workbench.app.picking.glance import Change
from workbench.gui.shared.visitor import Visitor
from workbench.model.cell import Tool
from workbench.model.derived.by_tcp import has_tcp, with_tcp
from workbench.model.digest import digest_of
from workbench.model.errors import CommandRefused, WorkbenchError
from workbench.model.messages.changes import GraspChange
from workbench.model.messages.commands import GraspEditText
from workbench.model.messages.message import Message
from workbench.model.part import Entry, Grasp, GraspLibrary, GraspPair, Part
from workbench.model.part_edits import free_name, grasp_of, names_in, with_grasp
from workbench.model.symmetry import Symmetry
from workbench.planning.grasps.grasp_check import GraspCheck, GraspChecker
from workbench.planning.kinematics.quickness import tool_acceleration

T = TypeVar("T")


class Editing:
    """The part and the grasp that a browser has in hand.

    Concurrency: any thread; a checker serves one at a time, so it is used under a lock.
    """

    def __init__(self, visitor: Visitor):
        """The first part of the cell, its first grasp, the first arm's tool."""
        self.visitor = visitor
        cell = visitor.cell
        self._part = cell.parts[0].name
        self._tool = cell.arms[0].tool.name
        entries = cell.parts[0].library.entries
        self._chosen = entries[0].name if entries else ""
        self.not_applied: Callable[[], str] = lambda: ""
        """Returns what a person does first with fields typed for the chosen grasp; else empty."""
        self.lost: Entry | None = None
        """What this browser wanted and did not get, since somebody else was quicker."""
        self._observers: list[Callable[[], None]] = []
        self._lock = threading.Lock()
        self._checkers: dict[str, tuple[str, GraspChecker]] = {}

    def on_change(self, observer: Callable[[], None]) -> None:
        """Have something called after another grasp, part or tool is chosen."""
        self._observers.append(observer)

    @property
    def part(self) -> Part:
        """The part as it is now."""
        parts = {part.name: part for part in self.visitor.cell.parts}
        return parts.get(self._part, self.visitor.cell.parts[0])

    @property
    def entry(self) -> Entry | None:
        """The chosen grasp or pattern as it is now; None when there is none."""
        entries = {entry.name: entry for entry in self.part.library.entries}
        return entries.get(self._chosen) or next(iter(entries.values()), None)

    @property
    def tools(self) -> dict[str, Tool]:
        """All tools of the cell's arms, by name."""
        arms = self.visitor.cell.arms
        return {tool.name: tool for arm in arms for tool in (arm.tool, *arm.tools)}

    @property
    def tool(self) -> Tool:
        """The one that grasps are tried with: that of the chosen grasp, if it is for one."""
        tools, entry = self.tools, self.entry
        wanted = grasp_of(entry).tool if entry is not None else ""
        tool = tools.get(wanted) or tools.get(self._tool) or next(iter(tools.values()))
        return tool if entry is None else _at_tcp_of(tool, grasp_of(entry))

    def choose(
        self, *, part: str | None = None, entry: str | None = None, tool: str | None = None
    ) -> None:
        """Take something else in hand."""
        self._part = self._part if part is None else part
        self._chosen = self._chosen if entry is None else entry
        self._tool = self._tool if tool is None else tool
        self.lost = None
        self.notify()

    def turn_to(self, *, part: str | None = None, entry: str) -> bool:
        """Choose another grasp by hand; refused while something is typed for the chosen one.

        Returns:
            Whether it was chosen.
        """
        if typed := self.not_applied():
            self.visitor.notify("Refused", typed)
            return False
        self.choose(part=part, entry=entry)
        return True

    def show_added(self, entry: str) -> None:
        """Choose a grasp that was added, unless something is typed for the chosen one."""
        if not self.not_applied():
            self.choose(entry=entry)

    def notify(self) -> None:
        """Have everybody who shows something look again."""
        for observer in self._observers:
            observer()

    def check(self, grasp: Grasp) -> GraspCheck:
        """What speaks against a grasp with the tool that it is for, or else with the one in use."""
        return self.with_checker(lambda checker: checker.check(grasp), self._tool_for(grasp))

    def _tool_for(self, grasp: Grasp) -> Tool:
        """The tool that a grasp is for, or the one in use, with the TCP that it is for."""
        return _at_tcp_of(self.tools.get(grasp.tool) or self.tool, grasp)

    def with_checker(self, asked: Callable[[GraspChecker], T], tool: Tool | None = None) -> T:
        """Ask the checker of the part and a tool, that in use when none is given, something."""
        part, tool = self.part, tool or self.tool
        with self._lock:
            is_weighed = part.friction is not None and tool.force is not None
            acceleration = tool_acceleration(self.visitor.cell, tool) if is_weighed else None
            held = (part.mass, part.friction, acceleration)
            key = digest_of((part.mesh, part.pieces, tool, held))
            known = self._checkers.get(tool.name)
            if known is None or known[0] != key:
                known = self._checkers[tool.name] = key, GraspChecker(part, tool, acceleration)
            return asked(known[1])

    def free_name(self, name: str) -> str:
        """The name, or one like it that is not taken."""
        return free_name(names_in(self.part.library.entries), name)

    def put(self, was: Entry, now: Entry, says: Message) -> bool:
        """Put an entry instead of one as this browser has seen it; whether that was done.

        When somebody else was quicker the wish is kept as `lost`.
        """
        command = EditPart(self.part.name, (was,), (now,), says=says)
        try:
            self.visitor.give(command)
        except CommandRefused as error:
            current = {entry.name: digest_of(entry) for entry in self.part.library.entries}
            if current.get(was.name) != digest_of(was):
                self.lost = now
            self.visitor.notify("Refused", str(error))
            self.notify()
            return False
        except WorkbenchError as error:
            self.visitor.notify("Refused", str(error))
            return False
        self.choose(entry=now.name)
        return True

    def put_grasp(self, was: Entry, grasp: Grasp, says: Message) -> bool:
        """Put another grasp in an entry; see `put`."""
        return self.put(was, with_grasp(was, grasp), says)

    def at(self, entry: Entry, T_part_tcp: pin.SE3) -> Grasp:
        """The grasp of an entry with the hand somewhere else."""
        return replace(grasp_of(entry), T_part_tcp=T_part_tcp)

    def moving(self, was: Entry, T_part_tcp: pin.SE3) -> Change:
        """What is other in the cell while the hand of an entry is dragged."""
        now, part = with_grasp(was, self.at(was, T_part_tcp)), self.part
        entries = tuple(now if entry.name == was.name else entry for entry in part.library.entries)
        return {"libraries": {part.name: replace(part.library, entries=entries)}}

    def move(self, was: Entry, T_part_tcp: pin.SE3, says: Message) -> bool:
        """Put the hand somewhere else; see `put`."""
        return self.put_grasp(was, self.at(was, T_part_tcp), says)

    def keep_lost(self) -> None:
        """Add what was lost to somebody quicker as a grasp of its own."""
        lost, self.lost = self.lost, None
        if lost is not None:
            copy = replace(grasp_of(lost), name=self.free_name(lost.name))
            says = GraspEditText.COPY_OF_LOST(copy=copy.name, grasp=lost.name)
            if self.add((with_grasp(lost, copy),), says):
                # It has what was typed.
                self.choose(entry=copy.name)

    def add(self, entries: Sequence[Entry], says: Message) -> bool:
        """Add entries at the end, and choose the first of them; see `show_added`."""
        if not self._ask(EditPart(self.part.name, (), tuple(entries), says=says)):
            return False
        self.show_added(entries[0].name)
        return True

    def remove(self, entry: Entry, now: Sequence[Entry], says: Message) -> bool:
        """Put none or several entries instead of one."""
        names = [known_entry.name for known_entry in self.part.library.entries]
        place = names.index(entry.name) if entry.name in names else 0
        if not self._ask(EditPart(self.part.name, (entry,), tuple(now), says=says)):
            return False
        left = [known_entry.name for known_entry in self.part.library.entries]
        self.choose(entry=left[min(place, len(left) - 1)] if left else "")
        return True

    def take_library(self, library: GraspLibrary, says: Message) -> bool:
        """Put another library instead of the one there is."""
        return self._ask(
            EditPart(
                self.part.name,
                self.part.library.entries,
                library.entries,
                pairs=library.pairs,
                pairs_was=self.part.library.pairs,
                says=says,
                searches=library.searches,
            )
        )

    def set_search(self, *, is_on: bool) -> bool:
        """Whether plans search grips where no grasp of the library takes a part."""
        says = GraspChange.SEARCH() if is_on else GraspChange.NO_SEARCH()
        return self._ask(EditPart(self.part.name, says=says, searches=is_on))

    def set_pairs(
        self, was: tuple[GraspPair, ...], pairs: Sequence[GraspPair], says: Message
    ) -> bool:
        """Which grasps go together, instead of the pairs that there were."""
        edit = EditPart(self.part.name, pairs=tuple(pairs), says=says, pairs_was=was)
        return self._ask(edit)

    def set_symmetry(self, symmetry: Symmetry) -> bool:
        """Say at which turns the part looks alike."""
        name = self.part.name
        return self._ask(EditPart(name, symmetry=symmetry, says=GraspEditText.SYMMETRY(part=name)))

    def _ask(self, command: EditPart) -> bool:
        return self.visitor.ask(lambda: command)


def _at_tcp_of(tool: Tool, grasp: Grasp) -> Tool:
    """A tool with the TCP that a grasp is for; with the first one where it has no such TCP."""
    return with_tcp(tool, grasp.tcp if has_tcp(tool, grasp.tcp) else "")
