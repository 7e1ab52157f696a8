"""The tabs of a browser, from left to right: the only place that knows all panels."""

from collections.abc import Callable

from workbench.app.core.commands import EditPart, SightPlate
from workbench.app.core.rights import RIGHTS
from workbench.app.review.history import History
from workbench.gui.calibration.panel import CalibrationPanel
from workbench.gui.candidates.panel import CandidatesPanel
from workbench.gui.cell.panel import CellPanel
from workbench.gui.cycle.panel import CyclePanel
from workbench.gui.grasps.panel import GraspsPanel
from workbench.gui.parts.panel import PartsPanel
from workbench.gui.plan.panel import PlanPanel
from workbench.gui.recorded.panel import RecordedPanel
from workbench.gui.robot.panel import RobotPanel
from workbench.gui.shared.visitor import Panel, Visitor
from workbench.gui.statistics.panel import StatisticsPanel


def tabs_of(visitor: Visitor, woken: Callable[[], None]) -> tuple[Panel, ...]:
    """Make the tabs of one browser, as far as its person has the role for them.

    Args:
        visitor: whose browser.
        woken: has the page drawn once more.
    """
    bench = visitor.bench
    made: list[tuple[str, Callable[[], Panel]]] = [
        ("Cycle", lambda: CyclePanel(visitor)),
        ("Parts", lambda: PartsPanel(visitor)),
        ("Candidates", lambda: CandidatesPanel(visitor, woken)),
        ("Plan", lambda: PlanPanel(visitor)),
        ("Robot", lambda: RobotPanel(visitor)),
        ("Cell", lambda: CellPanel(visitor)),
        ("Statistics", lambda: StatisticsPanel(visitor)),
    ]
    # Nothing in these is for anybody else, ever; the others are worth looking at.
    if visitor.person.role.covers(RIGHTS[EditPart].role):
        made.insert(5, ("Grasps", lambda: GraspsPanel(visitor)))
    if visitor.person.role.covers(RIGHTS[SightPlate].role):
        made.insert(-1, ("Calibration", lambda: CalibrationPanel(visitor)))
    if isinstance(bench, History):
        made.insert(0, ("Recorded", lambda: RecordedPanel(visitor, bench)))
    tabs = visitor.gui.add_tab_group()
    panels: list[Panel] = []
    for title, make in made:
        with tabs.add_tab(title):
            panels.append(make())
    return tuple(panels)
