"""The record by which a cell is accepted, of the session that runs, as a file to take along."""

from typing import Any

import viser

from workbench.app.review.commissioning import Targets
from workbench.app.runtime.bench import Bench
from workbench.gui.help.groups import group
from workbench.gui.shared.look import View
from workbench.gui.shared.visitor import Visitor
from workbench.plugins.extras import from_extra

ACCEPTANCE_FILE = "acceptance.html"


class AcceptanceControls:
    """What was agreed, and a button that writes the record.

    Concurrency: callbacks of viser and the renderer's thread; the view is replaced as a whole.
    """

    def __init__(self, visitor: Visitor):
        """Add the controls."""
        self._visitor = visitor
        self._shown: View | None = None
        gui, usual = visitor.gui, Targets()
        with group(gui, "Acceptance", expand_by_default=False):
            self._picks = gui.add_number(
                "Picks", usual.picks, min=1, step=1, hint="How many are judged: the last ones."
            )
            self._share = gui.add_number(
                "Parts taken [%]", 100 * usual.share, min=0.1, max=100, step=0.1
            )
            self._seconds = gui.add_number(
                "Time of a part [s]",
                0.0,
                min=0.0,
                step=0.1,
                hint="Of whole cycles without the approval, for each part taken. 0: not agreed.",
            )
            save = gui.add_button(
                "Save the acceptance record",
                icon=viser.Icon.DOWNLOAD,
                color="gray",
                hint="Picks against these targets, causes, the steps of commissioning, and lines "
                "for signatures.",
            )

        @save.on_click
        def _(_: Any) -> None:
            visitor.attempt(self._save)

    def show(self, new: View) -> None:
        """The record will be of this view."""
        self._shown = new

    def _save(self) -> None:
        view, bench = self._shown, self._visitor.bench
        if view is None or not isinstance(bench, Bench):
            return
        seconds = float(self._seconds.value) or None
        targets = Targets(int(self._picks.value), float(self._share.value) / 100, seconds)
        page = from_extra("evidence.acceptance:acceptance_page")
        session = bench.folder.name, *bench.head
        content = page(view.state, session, view.statistics, targets, view.at)
        self._visitor.client.send_file_download(ACCEPTANCE_FILE, content)
