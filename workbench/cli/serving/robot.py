"""`workbench send` and `workbench controller`: the two ends of the robot link."""

import logging
import math
import signal
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from types import FrameType

from workbench.app.core.rules import approve
from workbench.app.picking.proving import adopted, prove
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments import top as arguments
from workbench.cli.picking.planning import cell_of
from workbench.cli.terminal import check_number, check_whole, print_json, progress
from workbench.formats.cells.reading import read_cell
from workbench.formats.plans.plan_files import read_plan
from workbench.model.digest import canonical
from workbench.model.errors import FileError
from workbench.model.release import PartReport
from workbench.plugins.robot_link import Running, Simulation, controller_by, link_named
from workbench.plugins.robot_link import send as send_plan

HIGHEST_PORT = 65535


def send(typed: arguments.Send) -> int:
    """Prove, approve and send a plan; nothing is sent unless everything before it holds."""
    check_whole("--port", typed.port, 1, HIGHEST_PORT)
    plan, stated = read_plan(typed.plan)
    if stated and stated != plan.digest:
        raise FileError(
            typed.plan,
            f"was changed after the plan was made: it states digest {stated[:12]}, its content "
            f"has {plan.digest[:12]}; make a new plan",
        )
    cell = cell_of(plan, typed.cell)
    if not stated:
        plan = adopted(cell, plan)
    protocol, options = typed.protocol or cell.controller.link, cell.controller.options
    if protocol != cell.controller.link:
        options = {}
    controller = controller_by(protocol, typed.host, typed.port, options=options)
    cell = replace(cell, controller=controller)
    with progress("send") as report:
        make_ready(report, ("planning",))
        began = time.monotonic()
        report(0.0, "proving the plan")
        proof = prove(cell, plan)
        approval = approve(cell, plan, proof, typed.approve_as, time.time())
        sent: Counter[str] = Counter()
        parts: list[PartReport] = []
        for receipt in send_plan(plan, approval, cell):
            if receipt.sent:
                sent[receipt.arm or "both"] += 1
            if receipt.part is not None:
                parts.append(receipt.part)
            report(receipt.done / receipt.total, f"{receipt.arm} {receipt.sent or receipt.heard}")
    seconds = time.monotonic() - began
    if typed.json:
        form = {"ok": True, "digest": plan.digest, "approved_by": approval.actor}
        form |= {"protocol": protocol, "messages": dict(sent), "parts": canonical(parts)}
        print_json({**form, "seconds": round(seconds, 3)})
    else:
        counts = ", ".join(f"{count} for {arm}" for arm, count in sent.items())
        print(f"plan {plan.digest[:12]} approved by {approval.actor} and sent in {seconds:.1f} s")
        print(f"messages by {protocol}: {counts}; the controller has ended the last motion")
        for part in parts:
            print(f"arm {part.arm}: {'picked' if part.is_picked else f'failed, {part.why}'}")
    return 0


def controller(typed: arguments.Controller) -> int:
    """Run the simulated controller until SIGINT, SIGTERM, or the end of standard input."""
    state_port = typed.state_port
    if state_port is None:
        state_port = typed.port + 1 if typed.port else 0
    check_whole("--port", typed.port, 0, HIGHEST_PORT)
    check_whole("--state-port", state_port, 0, HIGHEST_PORT)
    check_number("--speed", typed.speed, 0.01, 1000)
    if typed.home_after is not None:
        check_number("--home-after", typed.home_after, 0.0, 3600.0)
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(message)s")
    cell = read_cell(typed.cell)

    def ready(running: Running) -> None:
        _end_with(running.stop, typed.until_eof)
        ports = {"host": typed.host, "port": running.port, "state_port": running.state_port}
        if typed.json:
            print_json(ports)
        else:
            what = "RAPID" if typed.rapid is not None else "simulated controller"
            state = (
                f"state on {typed.host}:{running.state_port}" if running.state_port else "no state"
            )
            print(
                f"{what} of cell {cell.name}: motion on {typed.host}:{running.port}, {state}; "
                "Ctrl-C ends it",
                flush=True,
            )

    simulation = Simulation(
        host=typed.host,
        port=typed.port,
        state_port=state_port,
        speed=typed.speed,
        record=typed.record,
        trace=typed.trace,
        faults=typed.fault,
        home_after=math.inf if typed.home_after is None else typed.home_after,
        rapid=typed.rapid,
    )
    link_named(cell.controller.link).serve(cell, simulation, ready)
    return 0


def _end_with(stop: Callable[[], None], at_eof: bool) -> None:
    """Stop at SIGINT, SIGTERM, and perhaps the end of standard input."""

    def by_signal(signum: int, frame: FrameType | None) -> None:
        stop()

    signal.signal(signal.SIGINT, by_signal)
    signal.signal(signal.SIGTERM, by_signal)
    if at_eof:
        threading.Thread(target=_stop_at_eof, args=(stop,), daemon=True).start()


def _stop_at_eof(stop: Callable[[], None]) -> None:
    while sys.stdin.buffer.read(4096):
        pass
    stop()
