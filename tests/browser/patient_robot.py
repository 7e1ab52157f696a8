"""A simulated controller in a process of its own, until its standard input ends.

Called with the speed and the file for what arrives; it prints its two ports as JSON.
"""

import json
import sys
import threading
from pathlib import Path

from patient import PATIENT

from workbench.devices.abb_simulated.controller import SimulatedController
from workbench.formats.cells.reading import read_cell
from workbench.plugins.robot_link import Simulation


def main(speed: str, record: str) -> None:
    robot = SimulatedController(
        read_cell("yumi"),
        Simulation(speed=float(speed), record=Path(record)),
        patience=PATIENT,
    )

    def until_eof() -> None:
        sys.stdin.read()
        robot.stop()

    threading.Thread(target=until_eof, daemon=True).start()
    print(json.dumps([robot.port, robot.state_port]), flush=True)
    robot.run()


if __name__ == "__main__":
    main(*sys.argv[1:])
