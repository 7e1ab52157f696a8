"""Jobs for the tests of the job runner: they run in a real worker process."""

import os
import time

import numpy as np
import pinocchio as pin

from workbench.app.emptying.film import Film, Filmed
from workbench.model.errors import FileError, InputError, JobCancelled
from workbench.model.messages.message import plain
from workbench.model.prediction import EmptiedPile, Emptying, LeftPart, PileTask
from workbench.model.scan import Detection, LocalizationResult, Objection, RejectedHypothesis, Scan


def echo(cell, arguments, report, cancelled):
    return {"cell": cell.name, "process": os.getpid(), **arguments}


def count(cell, arguments, report, cancelled):
    for step in range(5):
        report(step / 4, f"step {step}")
    return 5


def bring_nothing(cell, arguments, report, cancelled):
    return None


def flood(cell, arguments, report, cancelled):
    for step in range(20_000):
        report(step / 20_000, "the same note")
    return "done"


def wait_politely(cell, arguments, report, cancelled):
    report(0.0, "waiting")
    while not cancelled():
        time.sleep(0.005)
    raise JobCancelled("noticed")


def wait_stubbornly(cell, arguments, report, cancelled):
    report(0.0, "waiting")
    while True:
        time.sleep(600)


def refuse(cell, arguments, report, cancelled):
    raise FileError("scan.ply", "is truncated")


def stumble(cell, arguments, report, cancelled):
    return {}["missing"]


def bring_nonsense(cell, arguments, report, cancelled):
    return lambda: "functions made here cannot leave the process"


def bring_a_trap(cell, arguments, report, cancelled):
    class Trap:
        def __reduce__(self):
            return (int, ("a trap",))

    return Trap()


def die(cell, arguments, report, cancelled):
    os._exit(7)


def give_back(cell, arguments, report, cancelled):
    return arguments["scan"]


def scan(cell, arguments, report, cancelled):
    report(0.5, "the scanner looks")
    points = np.random.default_rng(arguments["seed"]).normal(size=(5000, 3))
    return Scan(points, pin.SE3.Identity(), "tiny")


def localize(cell, arguments, report, cancelled):
    if arguments["seed"] == 13:
        return (complex(1, 2),)
    if arguments["seed"] == 14:
        found = Detection(cell.parts[0].name, cell.bin.T_world_bin)
        lost = RejectedHypothesis(found.part, found.T_world_part, 0.4, Objection.REACHES_INTO, 0)
        return LocalizationResult((found,), (lost,))
    return wait_politely(cell, arguments, report, cancelled)


def emptying(cell, arguments, report, cancelled):
    asked = arguments["command"]
    task = PileTask(cell.name, cell.parts[0].name, asked.count, asked.seed)
    lies = ((0, Detection(cell.parts[0].name, cell.bin.T_world_bin)),)
    left = (LeftPart("part-1", "no path", plain("no way was found"), ""),)
    pile = EmptiedPile(task, 1, 0, (0, 0, 0), 0, 0, 0, 3, 0.0, left, (), (), 0.0)
    return Filmed(Emptying(cell.digest, (pile,)), (Film(task, lies, (), lies),))


def plan(cell, arguments, report, cancelled):
    raise InputError(f"no plan by strategy {arguments['strategy']}")


JOBS = {
    name: function
    for name, function in list(globals().items())
    if callable(function) and getattr(function, "__module__", "") == __name__
}
