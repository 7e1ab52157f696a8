"""The robot link `pick-server`: plans are asked for by any robot program, leg by leg."""

from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import contextmanager

from workbench.devices.pick_server.axes import axis_words
from workbench.devices.pick_server.carrying import Carrying
from workbench.devices.pick_server.options import (
    MOTION,
    PickOptions,
    form_of,
    motion_with,
    pick_options,
)
from workbench.devices.pick_server.pose_carrying import PoseCarrying
from workbench.devices.pick_server.poses import check_pose_lines, pose_program_of
from workbench.devices.pick_server.program import check_lines, program_of
from workbench.devices.pick_server.server import Server, listening
from workbench.model.cell import Cell
from workbench.model.errors import InputError, JobCancelled, LinkError
from workbench.model.messages.work import AskText, StopText
from workbench.model.motion import MotionModel
from workbench.model.plan import Plan
from workbench.model.release import Approval, LinkStatus, Receipt, RobotState
from workbench.model.scan import Option
from workbench.plugins.addresses import is_loopback
from workbench.plugins.progress import Cancelled
from workbench.plugins.robot_link import LinkPatience, Running, Simulation, check_approval

POLL_EVERY = 0.05

SLOWEST = 10.0
"""A leg may take this many times what was planned."""

ABSENT = 5.0
"""[s] Without a word for longer, no robot program is there."""


class PickServer:
    """The robot program stops at each waypoint, and asks before each leg."""

    Options = PickOptions
    motion = MOTION

    def motion_by(self, options: Mapping[str, Option]) -> MotionModel:
        """How a robot program moves that gets what these options say."""
        return motion_with(options)

    def check(self, cell: Cell) -> None:
        """One arm, whose waypoints fit the lines; a robot that is known by its address."""
        if len(cell.arms) != 1:
            raise InputError(
                f"the robot link {self.motion.link} moves one arm; this cell has {len(cell.arms)}"
            )
        if not pick_options(cell).client and not is_loopback(cell.controller.host):
            raise InputError(
                f"the pick server on {cell.controller.host} could be used by anybody: state the "
                "robot's address as `client`"
            )
        if cell.controller.motion.sends_poses:
            check_pose_lines(cell)
        else:
            check_lines(cell, axis_words(cell, form_of(cell)))

    def send(
        self,
        plan: Plan,
        approval: Approval,
        cell: Cell,
        *,
        now: Callable[[], float],
        cancelled: Cancelled,
        show: Callable[[LinkStatus], None],
        patience: LinkPatience,
    ) -> Iterator[Receipt]:
        """Offer the plan, and hand it out as it is asked for; a receipt for each answer."""

        def check_release() -> None:
            check_approval(plan, approval, cell, now())

        check_release()
        self.check(cell)
        axes, options = axis_words(cell, form_of(cell)), pick_options(cell)
        if cell.controller.motion.sends_poses:
            poses = pose_program_of(cell, plan, approval)
            carrying = PoseCarrying(
                poses, axes, now=now, released=check_release, cancelled=cancelled
            )
        else:
            program = program_of(cell, plan, approval, axes)
            carrying = Carrying(program, axes, now=now, released=check_release, cancelled=cancelled)
        with self.server_of(cell) as server:
            talk, clock = server.conversation, patience.clock
            began, told, progressed = clock(), 0, clock()
            talk.offer(carrying)
            try:
                while True:
                    talk.wait(POLL_EVERY)
                    self._show(cell, server, carrying, now, show)
                    while told < len(carrying.receipts):
                        told, progressed = told + 1, clock()
                        yield carrying.receipts[told - 1]
                    if carrying.is_over and told == len(carrying.receipts):
                        return
                    if carrying.fault is not None:
                        raise carrying.fault
                    if cancelled():
                        self._stop(server, carrying, patience)
                    if not carrying.is_taken and clock() - began > options.ask_s:
                        raise LinkError(AskText.NOBODY(seconds=options.ask_s))
                    if carrying.is_taken:
                        stood = clock() - progressed
                        _check_goes_on(carrying, talk.silence(), options.silence_s, stood)
            finally:
                talk.withdraw(carrying)

    def _stop(self, server: Server, carrying: Carrying, patience: LinkPatience) -> None:
        """Hand out nothing more, and wait for the robot program's word that it has stopped.

        Raises:
            JobCancelled: always.
        """
        talk, began = server.conversation, patience.clock()
        talk.stop(carrying)
        if not carrying.is_taken:
            raise JobCancelled(StopText.NOT_SPOKEN())
        how = StopText.NOT_ACKNOWLEDGED()
        while patience.clock() - began < patience.stop:
            talk.wait(POLL_EVERY)
            if carrying.is_acknowledged:
                how = StopText.ACKNOWLEDGED(took=patience.clock() - began)
                break
        raise JobCancelled(StopText.AT(where=carrying.where, how=how))

    def _show(
        self,
        cell: Cell,
        server: Server,
        carrying: Carrying,
        now: Callable[[], float],
        show: Callable[[LinkStatus], None],
    ) -> None:
        reported = server.conversation.reported
        joints = {cell.arms[0].name: reported.q} if reported is not None else None
        phase = "running" if carrying.is_taken else "waiting"
        done, legs = carrying.done, carrying.program.steps
        heard = carrying.receipts[-1] if carrying.receipts else None
        word, at = ("", 0.0) if heard is None else (heard.heard, heard.at)
        show(LinkStatus(self.motion.link, phase, done, legs, word, at, now(), joints=joints))

    def states(self, cell: Cell, cancelled: Cancelled) -> Iterator[RobotState]:
        """What the robot program reports; the server listens as long as somebody waits for it."""
        arm, last = cell.arms[0].name, 0
        with self.server_of(cell) as server:
            talk = server.conversation
            while not cancelled():
                talk.wait(POLL_EVERY)
                reported = talk.reported
                if last and talk.silence() > ABSENT:
                    raise LinkError(AskText.ABSENT())
                if reported is None or reported.count == last or talk.silence() > ABSENT:
                    continue
                last = reported.count
                moving = arm if talk.is_moving() else ""
                joints = {arm: tuple(reported.q.tolist())}
                yield RobotState(joints, {}, moving, talk.count, talk.placed, "")

    def serve(self, cell: Cell, simulation: Simulation, ready: Callable[[Running], None]) -> None:
        """A simulated robot program, which asks at the cell's address."""
        if simulation.rapid is not None:
            raise InputError("--rapid: pick-server runs no RAPID; see docs/pick_server.md")
        if simulation.trace is not None:
            raise InputError("--trace: the simulated robot program writes none")
        # Every cell that is read loads this module; only the simulation needs so much.
        from workbench.devices.pick_server.simulated import SimulatedProgram

        program = SimulatedProgram(cell, axis_words(cell, form_of(cell)), simulation)
        ready(program)
        program.run()

    @contextmanager
    def server_of(self, cell: Cell) -> Generator[Server]:
        """The server at the cell's address, which listens as long as the block runs."""
        axes, client = axis_words(cell, form_of(cell)), pick_options(cell).client
        with listening(cell, axes, client) as server:
            yield server


def _check_goes_on(carrying: Carrying, silent: float, patience: float, stood: float) -> None:
    """Refuse a robot program that says nothing, or that does not come on with its plan.

    Args:
        carrying: the plan that it has.
        silent: [s] since its last request.
        patience: [s] of the cell.
        stood: [s] since the last request of the plan.

    Raises:
        LinkError: one of both.
    """
    if silent > patience:
        raise LinkError(AskText.SILENCE(seconds=patience, where=carrying.where))
    longest = patience + SLOWEST * carrying.seconds
    if stood > longest:
        raise LinkError(AskText.NO_PROGRESS(seconds=longest, where=carrying.where))
