"""Makes `sessions/example` anew: one cycle of the YuMi cell against a simulated controller.

    .venv/bin/python sessions/make_example.py [FOLDER]

The scanner sees less than that of the cell file, so that the session stays small.
"""

import shutil
import sys
import threading
import time
from dataclasses import replace
from pathlib import Path

from workbench.app.core.cycle.outcomes import ReportPick
from workbench.app.runtime.bench import Bench
from workbench.cli.serving.demo import Cycle
from workbench.devices.abb_simulated.controller import SimulatedController
from workbench.formats.cells.reading import read_cell
from workbench.journal.journal import Journal
from workbench.plugins.robot_link import Simulation, controller_by

SEED = 0
RESOLUTION = (160, 120)


def main(folder: Path) -> None:
    """Write the session, in place of what was there."""
    cell = read_cell("yumi")
    cell = replace(cell, scanner=replace(cell.scanner, resolution=RESOLUTION))
    simulated = SimulatedController(cell, Simulation(speed=500))
    ports = {"port": simulated.port, "state_port": simulated.state_port}
    shutil.rmtree(folder, ignore_errors=True)
    bench = Bench(replace(cell, controller=controller_by("abb-socket", **ports)), Journal(folder))
    thread = threading.Thread(target=simulated.run)
    thread.start()
    try:
        time.sleep(1.0)  # until the controller's first report is there
        Cycle(bench, 1, [], lambda done, note: None).run(SEED)
        plan = bench.state.plan
        for arm in plan.arms if plan is not None else ():
            bench.do(ReportPick(arm.detection, True), "Ada")
    finally:
        bench.close()
        simulated.stop()
        thread.join()
    size = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
    print(f"{folder}: {size / 1024:.0f} kB")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "example")
