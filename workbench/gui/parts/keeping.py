"""What was found and what a person says is there, kept as a case; and those that were kept."""

import time
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path

import viser

from workbench.app.core.people import Role
from workbench.app.records.case_folder import There, case_files, keep_case, keeping_problem
from workbench.app.review.history import History
from workbench.gui.help.groups import group
from workbench.gui.shared.look import View
from workbench.gui.shared.views import line
from workbench.gui.shared.visitor import RECORDED, Visitor
from workbench.gui.texts.parts import PartsText
from workbench.model.errors import FileError, InputError

THERE: Mapping[str, There] = {
    "These parts and perhaps more": "listed",
    "These parts and no others": "listed alone",
    "Nothing": "nothing",
}

HINT = (
    "Correct the parts found first: veto, move, add. What was found and what you say is there "
    "go into one file, with scan and cell."
)


class KeepInputs:
    """What lies in the scan, a comment, the button, and the cases of this session.

    Concurrency: as `PartsPanel`.
    """

    def __init__(self, visitor: Visitor):
        """Add the controls."""
        self._visitor = visitor
        gui = visitor.gui
        with group(gui, "Keep as a case", expand_by_default=False):
            self._there = gui.add_dropdown(
                "In the bin",
                tuple(THERE),
                hint="What is found elsewhere counts as wrong only where there are no others.",
            )
            self._comment = gui.add_text("Comment", "", hint="What was wrong, in a line; kept.")
            self._keep = gui.add_button("Keep as a case", icon=viser.Icon.ARCHIVE, hint=HINT)
            self._kept = gui.add_html("")
        self._keep.on_click(lambda _: self._press())

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        if old is not None and old.state is new.state:
            return
        person = self._visitor.person
        problem = keeping_problem(new.state, person.name, person.role)
        words = self._visitor.words.render(problem)
        self._visitor.allow(self._keep, RECORDED if self._visitor.is_recorded else words)
        self._list()

    def _list(self) -> None:
        bench = self._visitor.bench
        try:
            kept = () if isinstance(bench, History) else case_files(bench.folder)
        except FileError:  # what cannot be read is said when something is to be kept
            kept = ()
        content = cases_html(kept, self._visitor.person.role)
        if self._kept.content != content:
            self._kept.content = content

    def _press(self) -> None:
        kept: list[Path] = []
        if self._visitor.attempt(lambda: kept.append(self._write_case())):
            self._comment.value, self._there.value = "", next(iter(THERE))
            self._list()
            stored = self._visitor.words.render(PartsText.STORED(path=str(kept[0])))
            self._visitor.notify("Kept", stored, color="blue")

    def _write_case(self) -> Path:
        bench, person = self._visitor.bench, self._visitor.person
        if isinstance(bench, History):
            raise InputError(RECORDED)
        there = THERE.get(self._there.value)
        if there is None:
            raise InputError("say first what lies in the bin")
        return keep_case(
            bench.folder,
            bench.state,
            self._comment.value,
            there,
            actor=person.name,
            role=person.role,
            at=time.time(),
        )


def cases_html(files: Sequence[Path], role: Role) -> str:
    """The cases of a session, the latest first; an engineer can take them along."""
    if not files:
        return ""
    names = [escape(file.name) for file in reversed(files)]
    if role.covers(Role.ENGINEER):
        names = [f'<a href="/cases/{name}" download>{name}</a>' for name in names]
    rows = "".join(f"<li>{name}</li>" for name in names)
    return (
        line("Cases kept in this session:", kind="hint")
        + f'<div class="wb-tree wb-along"><ul>{rows}</ul></div>'
    )
