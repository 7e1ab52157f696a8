"""The tabs of a browser, from left to right: the only place that knows all panels."""

import logging
from collections.abc import Callable
from functools import partial

import viser

from workbench.app.core.cell.part_edits import EditPart
from workbench.app.core.cycle.scanning import SightPlate
from workbench.app.review.history import History
from workbench.gui.calibration.panel import CalibrationPanel
from workbench.gui.candidates.panel import CandidatesPanel
from workbench.gui.cell.panel import CellPanel
from workbench.gui.cycle.panel import CyclePanel
from workbench.gui.emptying.panel import EmptyingPanel
from workbench.gui.grasps.panel import GraspsPanel
from workbench.gui.parts.panel import PartsPanel
from workbench.gui.plan.panel import PlanPanel
from workbench.gui.recorded.panel import RecordedPanel
from workbench.gui.robot.panel import RobotPanel
from workbench.gui.shared.icons import TAB_ICONS
from workbench.gui.shared.look import View
from workbench.gui.shared.visitor import Panel, Visitor
from workbench.gui.statistics.panel import StatisticsPanel
from workbench.gui.texts.page import PageText
from workbench.model.messages.message import plain
from workbench.plugins.found import load
from workbench.plugins.tab import ENTRY_POINTS as TABS
from workbench.plugins.tab import tab_names

log = logging.getLogger(__name__)


def tabs_of(visitor: Visitor, woken: Callable[[], None], slider: str) -> tuple[Panel, ...]:
    """Make the tabs of one browser, as far as its person has the role for them.

    Args:
        visitor: whose browser.
        woken: has the page drawn once more.
        slider: id of the slider of the plan's time.
    """
    bench = visitor.bench
    made: list[tuple[str, Callable[[], Panel]]] = [
        ("Cycle", lambda: CyclePanel(visitor)),
        ("Parts", lambda: PartsPanel(visitor)),
        ("Candidates", lambda: CandidatesPanel(visitor, woken)),
        ("Plan", lambda: PlanPanel(visitor, slider)),
        ("Robot", lambda: RobotPanel(visitor)),
        ("Cell", lambda: CellPanel(visitor)),
        ("Emptying", lambda: EmptyingPanel(visitor)),
        ("Statistics", lambda: StatisticsPanel(visitor)),
    ]
    # Nothing in these is for anybody else, ever; the others are worth looking at.
    if visitor.person.role.covers(EditPart.right.role):
        made.insert(5, ("Grasps", lambda: GraspsPanel(visitor)))
    if visitor.person.role.covers(SightPlate.right.role):
        made.insert(-1, ("Calibration", lambda: CalibrationPanel(visitor)))
    if isinstance(bench, History):
        made.insert(0, ("Recorded", lambda: RecordedPanel(visitor, bench)))
    made += [(name, partial(_foreign, name, visitor)) for name in tab_names()]
    tabs = visitor.gui.add_tab_group()
    panels: list[Panel] = []
    for title, make in made:
        with tabs.add_tab(title, TAB_ICONS.get(title, viser.Icon.PUZZLE)):
            panels.append(make())
    return tuple(panels)


class _Broken:
    """Instead of a tab that could not be made: what is the matter."""

    def __init__(self, visitor: Visitor, problem: str):
        broken = PageText.TAB_BROKEN(problem=plain(problem))
        visitor.gui.add_markdown(visitor.words.render(broken))

    def show(self, old: View | None, new: View) -> None:
        """Nothing changes."""


class _Guarded:
    """A tab of somebody else: an error in it is logged, and ends nothing but that tab."""

    def __init__(self, name: str, visitor: Visitor):
        tab: Panel = load(TABS, name)(visitor)
        self._tab: Panel | None = tab
        self._name, self._visitor = name, visitor

    def show(self, old: View | None, new: View) -> None:
        """As the tab does, until it fails."""
        if self._tab is None:
            return
        try:
            self._tab.show(old, new)
        except Exception:
            log.exception("tab %s failed and is not shown any more", self._name)
            self._tab = None


def _foreign(name: str, visitor: Visitor) -> Panel:
    try:
        return _Guarded(name, visitor)
    except Exception as error:
        log.exception("tab %s cannot be made", name)
        return _Broken(visitor, f"{type(error).__name__}: {error}")
