"""The tabs of a browser, from left to right: the only place that knows all panels."""

from collections.abc import Callable

from workbench.app.commands import EditPart, SightPlate
from workbench.app.history import History
from workbench.app.rights import RIGHTS
from workbench.gui.panels.calibration import CalibrationPanel
from workbench.gui.panels.candidates import CandidatesPanel
from workbench.gui.panels.cell import CellPanel
from workbench.gui.panels.cycle import CyclePanel
from workbench.gui.panels.grasps import GraspsPanel
from workbench.gui.panels.parts import PartsPanel
from workbench.gui.panels.plan import PlanPanel
from workbench.gui.panels.recorded import RecordedPanel
from workbench.gui.panels.robot import RobotPanel
from workbench.gui.panels.statistics import StatisticsPanel
from workbench.gui.visitor import Panel, Visitor


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
