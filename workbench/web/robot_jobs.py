"""The jobs of a robot program that need no plan, under the rules of an operator.

Approvals are not here: they are a person's.
"""

from collections.abc import Callable, Generator
from contextlib import contextmanager

from workbench.app.core.cell.bins import ChooseBin, NewBin, bin_numbered
from workbench.app.core.cell.kits import NewKit, kit_problem
from workbench.app.core.cell.recipes import ChooseRecipe
from workbench.app.core.command import Command
from workbench.app.core.cycle.arm_scanner import (
    path_problem,
    path_start,
    standing_joints,
    view_problem,
)
from workbench.app.core.cycle.empty_hand import PlanView
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import scan_of_pile
from workbench.app.core.cycle.sending import SendPlan, Stop
from workbench.app.core.cycle.unapproved import ReleasePoses, release_problem
from workbench.app.core.people import Role
from workbench.app.core.state import Phase, State
from workbench.app.runtime.bench import Bench
from workbench.devices.pick_server.axes import axis_words
from workbench.devices.pick_server.lines import LAST, BadLine, Request, read_whole
from workbench.devices.pick_server.link import PickServer
from workbench.devices.pick_server.options import form_of
from workbench.model.errors import CommandRefused
from workbench.model.recipes.recipe import HIGHEST_NUMBER, NO_RECIPE
from workbench.model.robot import HOME, ArmScanner
from workbench.plugins.robot_link import link_named

ACTOR = "robot program"

MOST_PARTS = 1000

Words = tuple[str, ...]


class BenchDesk:
    """Gives a bench the commands that a robot program asks for.

    A job that takes long begins by the first request and is answered `WAIT`; the same job, asked
    again in the same run of the robot program, has the result once.  Concurrency: the conversation
    calls it under its lock.
    """

    def __init__(self, bench: Bench) -> None:
        """Nothing has begun."""
        self._bench = bench
        self._begun = ""

    def phase(self) -> str:
        """Where the cycle stands."""
        return str(self._bench.state.phase)

    def begin_anew(self) -> None:
        """Give the new run no result of the one before: somebody may have rearranged the bin."""
        self._begun = ""

    def answer(self, request: Request) -> Words:
        """What is answered; see `Desk.answer`."""
        state = self._bench.state
        try:
            match request.job:
                case "scan":
                    parts = _whole(request, MOST_PARTS, 0) if request.words else None
                    return self._begin("scan", scan_of_pile(state, parts), _scan_answer)
                case "find":
                    return self._begin("find", FindParts(state.number), _find_answer)
                case "next":
                    return self._next(state)
                case "recipe":
                    number = _whole(request, HIGHEST_NUMBER, NO_RECIPE)
                    self._do(ChooseRecipe(number))
                    return "OK", str(number)
                case "kit":
                    self._do(NewKit())
                    return "OK", "kit"
                case "bin":
                    return self._choose_bin(state, _whole(request, LAST, 1))
                case "new-bin":
                    return self._new_bin(state, _whole(request, LAST, 1))
                case "view" | "home" as goal:
                    return self._path(state, request.words, goal)
                case "stop":
                    self._begun = ""
                    if state.phase is Phase.SENDING:
                        self._do(Stop())
                    return "OK", "stop"
                case _:
                    return "NO", "job"
        except CommandRefused:
            return self._refuse()

    def _begin(self, job: str, command: Command, result: Callable[[State], Words]) -> Words:
        state = self._bench.state
        if state.job is not None:
            return "WAIT", job
        if self._begun == job:
            self._begun = ""
            return result(state)
        self._do(command)
        self._begun = job
        return "WAIT", job

    def _next(self, state: State) -> Words:
        if state.job is not None:
            return "WAIT", "plan"
        match state.phase:
            case Phase.FAULT:
                return "STOP", "fault"
            case Phase.LOCALIZED if self._begun == "next":
                self._begun = ""
                return "NO", "plan"
            case Phase.LOCALIZED if kit_problem(state) is not None:
                return "NO", "kit"
            case Phase.LOCALIZED:
                self._do(MakePlan("", None, state.number))
                self._begun = "next"
                return "WAIT", "plan"
            case Phase.PLANNED if state.plan is not None and _is_unapproved(state):
                self._begun = ""
                self._do(ReleasePoses(state.plan.digest))
                return "WAIT", "plan"
            case Phase.PLANNED:
                self._begun = ""
                return "WAIT", "approval"
            case Phase.APPROVED if state.plan is not None:
                self._do(SendPlan(state.plan.digest))
                return "WAIT", "plan"
            case Phase.SENDING:
                return "WAIT", "plan"
            case _:
                return "NO", "find"

    def _path(self, state: State, words: Words, goal: str) -> Words:
        """The joints of view or home; or, asked with joints, the path there, which `next` gives."""
        cell, carrier = state.cell, state.cell.scanner.on_arm
        if carrier is None:
            return "NO", "view"
        axes = axis_words(cell, form_of(cell))
        is_back = goal == HOME
        if not words:
            return ("OK", *axes.format(carrier.home if is_back else carrier.view.q))
        joints = cell.joint_values({carrier.arm: axes.read(words, in_motion=False)})
        stands_at_home = path_start(cell, carrier, joints) == HOME
        if stands_at_home if is_back else view_problem(cell, joints) is None:
            return "OK", goal
        if state.job is not None:
            return "WAIT", "plan"
        if state.phase in (Phase.PLANNED, Phase.APPROVED) and _leads(state, carrier, goal):
            self._begun = ""
            return "WAIT", "approval"
        view = HOME if is_back else carrier.view.name
        if path_problem(cell, carrier, joints, view) is not None:
            return "NO", "view" if is_back else "home"
        if self._begun == goal:
            self._begun = ""
            return "NO", "plan"
        # What the robot program has just reported may be on its way to the bench.
        reported = standing_joints(cell, self._bench.live.joints)
        if path_problem(cell, carrier, reported, view) is None:
            self._do(PlanView(view, state.number))
            self._begun = goal
        return "WAIT", "plan"

    def _choose_bin(self, state: State, number: int) -> Words:
        name = bin_numbered(state, number)
        if name is None:
            return "NO", "bin"
        if name != state.cell.bin.name:
            self._do(ChooseBin(name))
        return "OK", str(max(1, self._bench.state.cell.bin.number))

    def _new_bin(self, state: State, number: int) -> Words:
        name = bin_numbered(state, number) if number else None
        if name is None:
            return "NO", "bin"
        self._do(NewBin(name))
        return "OK", str(number)

    def _refuse(self) -> Words:
        state = self._bench.state
        if state.phase is Phase.FAULT:
            return "STOP", "fault"
        return "NO", "control" if state.control not in ("", ACTOR) else str(state.phase)

    def _do(self, command: Command) -> None:
        self._bench.do(command, ACTOR, Role.OPERATOR)


@contextmanager
def robot_jobs(bench: Bench) -> Generator[None]:
    """Answer the robot program of a bench's cell as long as the block runs, if the link is one.

    Raises:
        LinkError: the address of the pick server cannot be had.
    """
    link = link_named(bench.cell.controller.link)
    if not isinstance(link, PickServer):
        yield
        return
    with link.server_of(bench.cell) as server:
        server.conversation.desk = BenchDesk(bench)
        yield


def _leads(state: State, carrier: ArmScanner, goal: str) -> bool:
    """Whether a proven plan takes the scanner to its view, or home."""
    plan, holds = state.plan, state.proof is not None and state.proof.holds
    if not holds or plan is None or not plan.is_view_plan:
        return False
    return carrier.leads_home(plan.arms[0].legs[0].q) == (goal == HOME)


def _is_unapproved(state: State) -> bool:
    """Whether poses go out without approval; a plan whose proof fails does not."""
    holds = state.proof is not None and state.proof.holds
    return holds and release_problem(state) is None


def _scan_answer(state: State) -> Words:
    return ("OK", "scan") if state.phase is Phase.SCANNED else ("NO", "scan")


def _find_answer(state: State) -> Words:
    count = len(state.detections or ())
    return ("OK", str(count)) if state.phase is Phase.LOCALIZED and count else ("NO", "parts")


def _whole(request: Request, most: int, usual: int) -> int:
    """The one whole number after a job.

    Raises:
        BadLine: there is more, or something else.
    """
    if len(request.words) > 1:
        raise BadLine("count")
    return read_whole(request.words[0], most) if request.words else usual
