"""The tab that tells what the session has brought, and gives it as a table to take along."""

import numpy as np
import viser

from workbench.app.records.statistics import csv_text
from workbench.gui.shared.charts import JOINTS, axis, curve
from workbench.gui.shared.look import View
from workbench.gui.shared.visitor import Visitor
from workbench.gui.statistics.views import statistics_html

FILE = "workbench-statistics.csv"
NOTHING = np.array([0.0, 1.0])


class StatisticsPanel:
    """Numbers and bars, cycle after cycle as curves, and a button for the CSV."""

    def __init__(self, visitor: Visitor):
        """Add the controls."""
        self._visitor = visitor
        self._shown: View | None = None
        gui = visitor.gui
        self._tables = gui.add_html("")
        self._cycles = gui.add_uplot(
            (NOTHING, NOTHING, NOTHING, NOTHING),
            (
                curve("cycle"),
                curve("find parts"),
                curve("plan", JOINTS[1]),
                curve("send", JOINTS[2]),
            ),
            scales={"x": {"time": False}},
            axes=(axis("cycle"), axis("time of a stage [s]")),
            height=170,
            visible=False,
        )
        self._save = gui.add_button("Save as CSV", icon=viser.Icon.DOWNLOAD, color="gray")
        self._save.on_click(lambda _: self._download())

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        self._shown = new
        counted = new.statistics
        if old is not None and old.statistics is counted:
            return
        self._tables.content = statistics_html(counted)
        self._save.disabled = not counted.picks
        timed = [cycle for cycle in counted.cycles if "send" in cycle.seconds]
        self._cycles.visible = len(timed) > 1
        if len(timed) > 1:
            self._cycles.data = (
                np.arange(1.0, len(timed) + 1),
                *(
                    np.array([cycle.seconds.get(stage, np.nan) for cycle in timed])
                    for stage in ("find parts", "plan", "send")
                ),
            )

    def _download(self) -> None:
        if self._shown is not None:
            content = csv_text(self._shown.statistics).encode()
            self._visitor.client.send_file_download(FILE, content)
