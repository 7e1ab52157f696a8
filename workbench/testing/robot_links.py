"""The promises of robot links, tried on the simulated controller that the link brings."""

import threading
import time
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from dataclasses import replace

from workbench.model.cell import Cell
from workbench.model.errors import CommandRefused, JobCancelled, LinkError
from workbench.model.plan import Plan
from workbench.model.release import Approval, LinkStatus, Receipt
from workbench.plugins.progress import never
from workbench.plugins.robot_link import (
    LinkPatience,
    RobotLink,
    Running,
    Simulation,
    motion_of,
    send,
    states,
)
from workbench.testing.options import check_options

LONGEST_WAIT = 120.0
"""[s] Timeout of everything that must come; only a link that hangs reaches it."""


@contextmanager
def simulated(
    link: RobotLink, cell: Cell, speed: float, host: str = "127.0.0.1"
) -> Generator[Cell]:
    """The cell with its controller where the link's simulated controller runs, in a thread."""
    began, running = threading.Event(), list[Running]()

    def ready(running_link: Running) -> None:
        running.append(running_link)
        began.set()

    wanted = Simulation(host, 0, 0, speed, None, None, (), float("inf"))
    thread = threading.Thread(target=link.serve, args=(cell, wanted, ready), daemon=True)
    thread.start()
    assert began.wait(LONGEST_WAIT), "the simulated controller did not start"
    at = replace(
        cell.controller,
        host=host,
        port=running[0].port,
        state_port=running[0].state_port,
    )
    try:
        yield replace(cell, controller=at)
    finally:
        running[0].stop()
        thread.join(LONGEST_WAIT)
        assert not thread.is_alive(), "the simulated controller did not stop"


def check_robot_link(
    link: RobotLink, cell: Cell, plan: Plan, approval: Approval, host: str = "127.0.0.1"
) -> None:
    """A link sends the whole approved plan once, stops on command, and reports both.

    Args:
        link: an object of the declared class.
        cell: a cell that uses this link.
        plan: a plan for this cell with a valid proof.
        approval: the plan's approval, valid now.
        host: address of the simulated controller.  If its ports are fixed, and several run at a
            time, it needs its own address 127.x.y.z.
    """
    assert cell.controller.motion == motion_of(link, cell.controller.options), (
        "the cell has to be spoken to by this link"
    )
    check_options(link.Options, cell.controller.options)
    link.check(cell)
    patience = LinkPatience(LONGEST_WAIT, LONGEST_WAIT, LONGEST_WAIT, LONGEST_WAIT, LONGEST_WAIT)
    with simulated(link, cell, 100.0, host) as there:
        shown: list[LinkStatus] = []
        receipts = list(send(plan, approval, there, show=shown.append, patience=patience))
        _check_receipts(link, plan, receipts)
        assert shown, "nobody was told how the link stands"
        _check_states(link, plan, there, receipts)
        for change in ("plan_digest", "cell_digest", "scan_digest"):
            other = replace(approval, **{change: "0" * 64})
            assert _is_refused(plan, other, there), f"an approval with another {change} was taken"
            try:
                list(_straight(link, plan, other, there, patience))
            except CommandRefused:
                continue
            raise AssertionError(f"the link itself took an approval with another {change}")
    _check_steps(link, cell, plan, replace(approval, is_stepped=True), host, patience)
    with simulated(link, cell, 0.2, host) as there:
        began, taken = time.monotonic(), list[Receipt]()

        def is_enough() -> bool:
            assert time.monotonic() - began < LONGEST_WAIT, (
                "`cancelled` is to be asked all the time"
            )
            return bool(taken)

        try:
            for receipt in send(plan, approval, there, cancelled=is_enough, patience=patience):
                taken.append(receipt)
        except JobCancelled:
            pass
        else:
            raise AssertionError("a sending that was stopped came to its end")
    nowhere = replace(cell.controller, host="127.0.0.1", port=9)
    try:
        list(send(plan, approval, replace(cell, controller=nowhere), patience=patience))
    except LinkError:
        return
    raise AssertionError("nobody listens there, and that was no LinkError")


def _check_receipts(link: RobotLink, plan: Plan, receipts: list[Receipt]) -> None:
    assert receipts, "there are receipts of what was sent"
    done = [receipt.done for receipt in receipts]
    assert done == sorted(done), "receipts count upwards"
    assert done[-1] == receipts[-1].total, "the last receipt tells of the last message"
    if link.motion.reports_progress:
        parts = {receipt.part.arm: receipt.part for receipt in receipts if receipt.part is not None}
        assert set(parts) == {arm.arm for arm in plan.arms}, "each part of the plan is told of"


def _check_states(link: RobotLink, plan: Plan, cell: Cell, receipts: list[Receipt]) -> None:
    """Reported states are possible; outcomes of parts are reported, unless the link never does."""
    began = time.monotonic()
    reports = states(cell, lambda: time.monotonic() - began > LONGEST_WAIT)
    has_outcome = any(receipt.part is not None for receipt in receipts)
    has_outcome = has_outcome or not getattr(link, "tells_of_parts", True)
    for state in reports:
        # `states` has looked at every number of it.
        if has_outcome or state.placed >= len(plan.arms):
            return
    assert has_outcome, (
        "no part has an outcome: a link that reports none states `tells_of_parts = False`"
    )


def _check_steps(
    link: RobotLink, cell: Cell, plan: Plan, approval: Approval, host: str, patience: LinkPatience
) -> None:
    if not link.motion.takes_steps:
        assert _is_refused(plan, approval, cell), "a link that cannot wait was given a stepped plan"
        return
    with simulated(link, cell, 100.0, host) as there:
        waited = [0]
        for receipt in send(plan, approval, there, patience=patience, let=lambda: waited[-1]):
            if receipt.waits:
                waited.append(receipt.waits)
        steps = list(range(len(plan.sequence) + 1))
        assert waited == steps, "the robot waits once before each step, the first one too"


def _is_refused(plan: Plan, approval: Approval, cell: Cell) -> bool:
    try:
        list(send(plan, approval, cell))
    except CommandRefused:
        return True
    return False


def _straight(
    link: RobotLink, plan: Plan, approval: Approval, cell: Cell, patience: LinkPatience
) -> Iterator[Receipt]:
    return link.send(
        plan,
        approval,
        cell,
        now=time.time,
        cancelled=never,
        show=lambda status: None,
        patience=patience,
    )
