"""`workbench demo`: whole cycles through the same bench as the page, against a controller."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from workbench.app.core.cell.bins import ChooseBin
from workbench.app.core.cell.recipes import ChooseRecipe
from workbench.app.core.command import Command
from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.arm_scanner import view_problem
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import SendPlan
from workbench.app.core.cycle.standing import moved_away
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.session import Started
from workbench.app.core.state import Phase, State
from workbench.app.core.value_checks import SEED_LIMIT
from workbench.app.provenance.gathering import inventory
from workbench.app.records.sessions import new_session
from workbench.app.runtime.bench import Bench
from workbench.cli.arguments import top as arguments
from workbench.cli.arguments.access import USERS
from workbench.cli.exits import NO_PLAN, SUCCESS
from workbench.cli.picking.results import candidate_form, plan_form, print_candidates, proof_form
from workbench.cli.serving.people import roles
from workbench.cli.serving.simulation import simulated_controller
from workbench.cli.terminal import (
    check_number,
    check_whole,
    milliseconds,
    print_json,
    print_table,
    progress,
)
from workbench.formats.cells.reading import read_cell
from workbench.model.cell import Cell
from workbench.model.errors import LinkError, WorkbenchError
from workbench.model.messages.message import Message
from workbench.plugins.progress import Report
from workbench.plugins.robot_link import link_named

ACTOR = "demo"
DEMO_PARTS = 2

PROGRESS_EVERY = 0.1
"""Progress is shown this often [s]."""

REPORTED = 10.0
"""How long [s] a report may take that shows the robot where the next plan starts."""


@dataclass(frozen=True, slots=True)
class StageRow:
    """One stage of one cycle as it went; `seconds` without what a task had to wait for."""

    cycle: int
    stage: str
    result: str
    seconds: float


class NoPlan(Exception):
    """A cycle ended before the robot: there was nothing to take, or no way to take it."""


def demo(typed: arguments.Demo) -> int:
    """Run the cycles; the exit code is 0 only when the controller reported all parts placed."""
    check_whole("--cycles", typed.cycles, 1, 10_000)
    check_whole("--seed", typed.seed, 0, SEED_LIMIT - typed.cycles)
    check_number("--speed", typed.speed, 0.01, 1000)
    cell = read_cell(typed.cell)
    rows: list[StageRow] = []
    cycles: list[dict[str, Any]] = []
    code, why = SUCCESS, ""
    with simulated_controller(typed.cell, cell.controller, speed=typed.speed) as controller:
        cell = replace(cell, controller=controller)
        journal = new_session(typed.sessions, cell, time.time())
        bench = Bench(cell, journal, start=Started(inventory(cell, roles(USERS)), is_trial=True))
        try:
            with progress("demo") as report:
                if typed.recipe:
                    bench.do(ChooseRecipe(typed.recipe), ACTOR)
                if typed.bin:
                    bench.do(ChooseBin(typed.bin), ACTOR)
                for number in range(typed.cycles):
                    Cycle(bench, number + 1, rows, report).run(typed.seed + number)
                    cycles.append(_cycle_form(typed.seed + number, bench.state))
        except NoPlan as error:
            code, why = NO_PLAN, str(error)
        finally:
            bench.close()
    state = bench.state
    if typed.json:
        print_json(
            {
                "ok": code == SUCCESS,
                "problem": why,
                "cell": cell.name,
                "controller": f"{controller.host}:{controller.port}",
                "session": str(journal.folder),
                "cycles": cycles,
                "stages": [
                    {
                        "cycle": row.cycle,
                        "stage": row.stage,
                        "result": row.result,
                        "ms": milliseconds(row.seconds),
                    }
                    for row in rows
                ],
                "candidates": []
                if code == SUCCESS
                else [candidate_form(candidate) for candidate in state.candidates or ()],
            }
        )
        return code
    print_table(
        f"cell {cell.name}, controller {controller.host}:{controller.port}",
        ("cycle", "stage", "result", "ms"),
        ((str(row.cycle), row.stage, row.result, f"{milliseconds(row.seconds):,}") for row in rows),
    )
    if code != SUCCESS:
        print_candidates("every candidate", state.candidates or ())
        print(why)
    print(f"session: {journal.folder}")
    return code


class Cycle:
    """One cycle: gives the commands that a person would click, and keeps what came of them."""

    def __init__(self, bench: Bench, number: int, rows: list[StageRow], report: Report) -> None:
        self._bench = bench
        self._number = number
        self._rows = rows
        self._report = report

    def run(self, seed: int, then: int | None = None) -> None:
        """From scan to robot; a plan that was made beside the cycle before is sent as it is.

        Args:
            seed: of the pile.
            then: seed of the next pile, which is continued meanwhile; None: it waits.

        Raises:
            NoPlan: there is nothing to send.
            LinkError: the controller did not report the cycle as finished, with all parts placed.
            WorkbenchError: a stage failed.
        """
        state = self._bench.state
        if state.phase is not Phase.PLANNED:
            state = self._plan(seed)
        plan, proof = state.plan, state.proof
        if plan is None or proof is None or not proof.holds:
            raise NoPlan(str(state.message))
        self._wait_while(lambda cell, joints: moved_away(cell, plan, joints))
        # Nobody looks: the record says who has let this plan out, a demonstration.
        row = tuple(proven_plan.plan.digest for proven_plan in state.row)
        self._bench.do(WatchPlan(plan.digest, is_reported=True, row=row), ACTOR)
        self._stage("approve", Approve(plan.digest, row=row), Phase.APPROVED)
        if then is not None:
            self._stage("send", SendPlan(plan.digest), *Phase, after=_next(then))
            state = self._bench.state
        else:
            state = self._stage("send", SendPlan(plan.digest), Phase.DONE, Phase.FAULT)
        if state.phase is Phase.FAULT:
            raise LinkError(state.fault)
        is_over = state.phase is Phase.DONE
        if is_over and self._reports_parts(state) and state.parts_placed != len(plan.picks):
            raise LinkError(str(state.message))

    def _plan(self, seed: int) -> State:
        """The state with what planning has brought for a new pile."""
        self._wait_while(view_problem)
        self._stage("scan", TakeScan(seed, DEMO_PARTS), Phase.SCANNED)
        state = self._stage("find parts", FindParts(seed), Phase.SCANNED, Phase.LOCALIZED)
        if not state.detections:
            raise NoPlan("no parts were found in the scan")
        wanted = MakePlan("", None, seed)
        return self._stage("plan", wanted, Phase.LOCALIZED, Phase.PLANNED)

    def _wait_while(self, problem: Callable[[Cell, Mapping[str, float]], Message | None]) -> None:
        """Wait until the reported joints have no such problem, at most `REPORTED` seconds.

        The controller reports the robot's rest after the end of a plan.  A problem that stays is
        refused by the next command, which states the distance.
        """
        cell, until = self._bench.state.cell, time.monotonic() + REPORTED
        while problem(cell, self._bench.live.joints) and time.monotonic() < until:
            time.sleep(PROGRESS_EVERY / 10)

    def _reports_parts(self, state: State) -> bool:
        """Whether the controller says what became of parts; of some only the end is known."""
        link = link_named(state.cell.controller.link)
        return getattr(link, "tells_of_parts", True)

    def _stage(
        self, name: str, command: Command, *expected: Phase, after: Command | None = None
    ) -> State:
        began = time.time()
        before = self._bench.state.number
        state = self._bench.do(command, ACTOR)
        if after is not None:
            state = self._bench.do(after, ACTOR)
        # However long it takes: a worker that dies and a robot that is silent end it themselves.
        while not _is_settled(state):
            state = self._bench.wait(_is_settled, PROGRESS_EVERY)
            self._report_stage(name, before, state)
        live = self._bench.live
        seconds = time.time() - (live.started if live.job > before else began)
        self._rows.append(StageRow(self._number, name, str(state.message), seconds))
        if state.phase not in expected:
            raise WorkbenchError(f"{name}: {state.message}")
        return state

    def _report_stage(self, name: str, before: int, state: State) -> None:
        """Report how far a stage is that began after the entry `before`."""
        live = self._bench.live
        share, says = live.done if live.job > before else 0.0, str(state.message)
        if live.getting_ready is not None:
            share, says = live.getting_ready.done, live.getting_ready.note
        self._report(share, f"cycle {self._number}, {name}: {says}")


def _next(seed: int) -> GoOn:
    """The wish to go on with the next pile as this one was planned."""
    wanted = MakePlan("", None, seed)
    return GoOn(TakeScan(seed, DEMO_PARTS), FindParts(seed), wanted)


def _is_settled(state: State) -> bool:
    return state.job is None and state.phase is not Phase.SENDING


def _cycle_form(seed: int, state: State) -> dict[str, Any]:
    return {
        "seed": seed,
        "parts_placed": state.parts_placed,
        "plan": None if state.plan is None else plan_form(state.plan, state.bound),
        "proof": None if state.proof is None else proof_form(state.proof),
    }
