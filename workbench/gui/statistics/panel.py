"""The tab that states what the session has brought, and gives it as a table to take along."""

from collections.abc import Sequence

import numpy as np
import viser

from workbench.app.core.people import Role
from workbench.app.statistics.cycles import CycleRecord
from workbench.app.statistics.statistics_table import csv_text
from workbench.gui.help.groups import group
from workbench.gui.shared.colours import JOINTS
from workbench.gui.shared.look import View
from workbench.gui.shared.plots import Curve, Plot, legend_html, plot_html
from workbench.gui.shared.views import line
from workbench.gui.shared.visitor import Visitor
from workbench.gui.statistics.acceptance import AcceptanceControls
from workbench.gui.statistics.learning import LearningControls
from workbench.gui.statistics.restoring import RestoreControls
from workbench.gui.statistics.views import statistics_html

STATISTICS_FILE = "workbench-statistics.csv"

WHOLE = "Of the whole session, whichever entry is shown."

ALONG = (
    '<div class="wb-pad"><div class="wb-small wb-along"><a href="/session.zip" download>'
    "Session as one file</a> for whoever helps, with the log; "
    '<a href="/backup.zip" download>Backup</a> of cells and parts.</div></div>'
)
"""What the front gives an engineer."""


class StatisticsPanel:
    """Numbers and bars, cycle after cycle as curves, and a button for the CSV."""

    def __init__(self, visitor: Visitor):
        """Add the controls."""
        self._visitor = visitor
        self._shown: View | None = None
        gui = visitor.gui
        self._tables = gui.add_html("")
        self._learning: LearningControls | None = None
        if not visitor.is_recorded and visitor.person.role.covers(Role.ENGINEER):
            self._learning = LearningControls(visitor)
        self._cycles = gui.add_html("")
        self._save = gui.add_button("Save as CSV", icon=viser.Icon.DOWNLOAD, color="gray")
        self._save.on_click(lambda _: self._download())
        self._acceptance = None if visitor.is_recorded else AcceptanceControls(visitor)
        self._restore: RestoreControls | None = None
        if not visitor.is_recorded and visitor.person.role.covers(Role.ENGINEER):
            gui.add_html(ALONG)
            with group(gui, "Restore a backup", expand_by_default=False):
                self._restore = RestoreControls(visitor)

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        self._shown = new
        if self._acceptance is not None:
            self._acceptance.show(new)
        if self._restore is not None and (
            old is None or old.state is not new.state or old.live is not new.live
        ):
            self._restore.show(new)
        counted = new.statistics
        if self._learning is not None and (
            old is None or old.state is not new.state or old.statistics is not counted
        ):
            self._learning.show(new)
        if old is not None and old.statistics is counted:
            return
        whole = line(WHOLE, kind="hint") if new.is_recorded else ""
        self._tables.content = whole + statistics_html(counted, self._visitor.words)
        self._save.disabled = not counted.picks
        timed = [cycle for cycle in counted.cycles if "send" in cycle.seconds]
        self._cycles.content = stage_curves(timed) if len(timed) > 1 else ""

    def _download(self) -> None:
        if self._shown is not None:
            content = csv_text(self._shown.statistics).encode()
            self._visitor.client.send_file_download(STATISTICS_FILE, content)


def stage_curves(cycles: Sequence[CycleRecord]) -> str:
    """How long the stages took, cycle after cycle."""
    curves = tuple(
        Curve(stage, JOINTS[k], np.array([cycle.seconds.get(stage, np.nan) for cycle in cycles]))
        for k, stage in enumerate(("find parts", "plan", "send"))
    )
    numbers = np.arange(1.0, len(cycles) + 1)
    plot = Plot("Time of a stage", "s", numbers, curves, low=0.0, along="cycle")
    return plot_html(plot, float(numbers[-1])) + legend_html(plot)
