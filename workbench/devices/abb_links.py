"""The two robot links of ABB controllers, as the seam wants them."""

from collections.abc import Callable, Iterator

from workbench.devices.abb_socket.link import send_messages, send_program
from workbench.devices.abb_socket.program import LONGEST_WAY
from workbench.devices.abb_socket.reports import watch_state
from workbench.model.cell import Cell
from workbench.model.motion import MotionModel
from workbench.model.release import RobotState
from workbench.plugins.options import NoOptions
from workbench.plugins.progress import Cancelled
from workbench.plugins.robot_link import Running, Simulation


class AbbSocket:
    """Asks for message after message, and stops at each waypoint; see `docs/protocol.md`."""

    motion = MotionModel("abb-socket", corners="stop", unit="deg", decimals=2)
    Options = NoOptions
    send = staticmethod(send_messages)

    def check(self, cell: Cell) -> None:
        """Any cell."""

    def states(self, cell: Cell, cancelled: Cancelled) -> Iterator[RobotState]:
        """What comes from the port beside the one for motion."""
        return watch_state(cell.controller.host, cell.controller.state_port, cancelled)

    def serve(self, cell: Cell, simulation: Simulation, ready: Callable[[Running], None]) -> None:
        """The simulated controller, which speaks both, or RAPID modules that do."""
        if simulation.rapid is not None:
            from workbench.devices.rapid.serving import serve_modules

            serve_modules(cell, simulation, ready)
            return
        # Every cell that is read loads this module; only the simulation needs so much.
        from workbench.devices.abb_simulated.controller import SimulatedController

        controller = SimulatedController(cell, simulation)
        ready(controller)
        controller.run()


class AbbProgram(AbbSocket):
    """Loads a plan as a program, moves two arms at once, and rounds corners."""

    motion = MotionModel(
        "abb-socket/2",
        corners="blend",
        unit="deg",
        decimals=2,
        arms_at_once=2,
        reports_progress=True,
        takes_share=True,
        takes_steps=True,
        takes_loads=True,
        takes_openings=True,
        takes_tools=True,
        keeps_hand=True,
        longest=LONGEST_WAY,
    )
    send = staticmethod(send_program)
