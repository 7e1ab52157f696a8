"""Controllers of Universal Robots as the seam wants them."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from workbench.devices.universal_robots.flange import Flange
from workbench.devices.universal_robots.program import ProgramSettings, program_of
from workbench.devices.universal_robots.received_states import States
from workbench.devices.universal_robots.rtde import RTDE_PORT
from workbench.devices.universal_robots.sending import RtdeSending
from workbench.devices.universal_robots.servo import PERIOD, Servo
from workbench.devices.universal_robots.talking import Client
from workbench.model.cell import Cell
from workbench.model.errors import InputError, LinkError
from workbench.model.messages.devices import DeviceText
from workbench.model.motion import MotionModel
from workbench.model.plan import Plan
from workbench.model.release import Approval, LinkStatus, Receipt, RobotState
from workbench.plugins.options import option, options_of
from workbench.plugins.progress import Cancelled
from workbench.plugins.robot_link import USUAL, LinkPatience, Running, Simulation, check_approval

POLL_EVERY = 0.1
"""[s] Between two looks whether to end."""


class UrRtde:
    """Loads a plan as one program, which stops at each waypoint; reports by RTDE."""

    @dataclass(frozen=True)
    class Options:
        """Keys in `[controller.options]`."""

        gripper_output: int = option(
            0, low=0, high=7, says="digital output that closes the gripper or turns on the suction"
        )
        grip_s: float = option(0.5, low=0.0, high=10.0, says="what the gripper needs [s]")
        payload_inertia: bool = option(
            True, says="set_target_payload with inertia; false: set_payload, as old controllers do"
        )

    motion = MotionModel(
        "ur-rtde", corners="stop", unit="rad", decimals=6, takes_loads=True, takes_outputs=True
    )

    tells_of_parts = False
    """What became of parts is not reported, only that the program has ended."""

    def check(self, cell: Cell) -> None:
        """One arm of six turning joints, at the port that RTDE has."""
        kinds = [cell.robot.joint(name).kind for arm in cell.arms for name in arm.joints]
        if len(cell.arms) != 1 or kinds != ["revolute"] * 6:
            raise InputError(
                f"the robot link {self.motion.link} moves one arm of six turning joints; this cell "
                f"has {len(cell.arms)} arms with {len(kinds)} joints"
            )
        if cell.controller.state_port != RTDE_PORT:
            raise InputError(
                f"[controller] state_port = {cell.controller.state_port}: ur-rtde reads states at "
                f"{RTDE_PORT}; programs go to port 30002"
            )

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
        """Load the program and follow it to its end; one receipt for it, and one for each leg."""

        def check_release() -> None:
            check_approval(plan, approval, cell, now())

        check_release()
        self.check(cell)
        options = options_of(self.Options, cell.controller.options)
        settings = self._settings(options, patience.silence, approval)
        program = program_of(cell, plan, approval, settings)
        ports = (cell.controller.port, RTDE_PORT)
        with Client(cell.controller.host, ports, sends=True) as client:
            talk = RtdeSending(
                client,
                cell,
                program,
                now=now,
                show=show,
                patience=patience,
                link=self.motion.link,
            )
            yield from talk.run(check_release, cancelled)

    def _settings(self, options: Any, silence: float, approval: Approval) -> ProgramSettings:
        """What a program takes from the link's `Options`."""
        hand = options.gripper_output, options.grip_s
        return ProgramSettings(*hand, silence, sends_inertia=options.payload_inertia)

    def states(self, cell: Cell, cancelled: Cancelled) -> Iterator[RobotState]:
        """What RTDE reports, whenever it has changed."""
        self.check(cell)
        arm = cell.arms[0]
        before: RobotState | None = None
        # Until the first state the client connects, which may take it longer.
        silence, fresh, states = USUAL.answer, time.monotonic(), States(cell, arm)
        with Client(cell.controller.host, (RTDE_PORT,), sends=False) as client:
            while not cancelled():
                # The library goes on telling the last that it heard when a cable is cut.
                news = states.take(client.hear(POLL_EVERY), in_motion=False)
                if news is None:
                    if time.monotonic() - fresh > silence:
                        raise LinkError(DeviceText.NOTHING_NEW(seconds=silence))
                    continue
                fresh, silence = time.monotonic(), USUAL.silence
                moving = "" if news.stands else arm.name
                joints = {arm.name: tuple(news.q.tolist())}
                state = RobotState(joints, {}, moving, 0, 0, news.fault)
                if state != before:
                    before = state
                    yield state

    def serve(self, cell: Cell, simulation: Simulation, ready: Callable[[Running], None]) -> None:
        """The controller's twin; its ports for RTDE and the dashboard are those of the real one."""
        if simulation.rapid is not None:
            raise InputError("--rapid: ur-rtde knows no RAPID")
        if simulation.state_port not in (0, RTDE_PORT):
            raise InputError(
                f"--state-port {RTDE_PORT} is the only one: the client chooses no other"
            )
        # Every cell that is read loads this module; only the simulation needs so much.
        from workbench.devices.universal_robots.twin import SimulatedUr

        arm = cell.arms[0]
        twin = SimulatedUr(
            simulation, arm.to_axes(arm.home).tolist(), positions=Flange(cell, arm).at
        )
        ready(twin)
        twin.run()


class UrRtdeBlend(UrRtde):
    """Rounds corners, by no more than was proven; see `blends` for what that takes for granted."""

    @dataclass(frozen=True, slots=True)
    class Options(UrRtde.Options):
        """Keys in `[controller.options]`."""

        blend_mm: float = option(
            50.0, low=0.0, high=500.0, says="largest radius at the flange of a blend [mm]"
        )

    motion = MotionModel(
        "ur-rtde-blend",
        corners="blend",
        unit="rad",
        decimals=6,
        takes_loads=True,
        takes_outputs=True,
    )

    def _settings(self, options: Any, silence: float, approval: Approval) -> ProgramSettings:
        settings = super()._settings(options, silence, approval)
        return replace(settings, blend=options.blend_mm / 1000.0)


class UrRtdeServo(UrRtde):
    """Streams references along the proven way by `servoj`; see `servo` for what holds then."""

    @dataclass(frozen=True, slots=True)
    class Options(UrRtde.Options):
        """Keys in `[controller.options]`."""

        lookahead_s: float = option(
            0.03, low=0.03, high=0.2, says="lookahead_time of servoj, by which the arm lags [s]"
        )
        gain: int = option(2000, low=100, high=2000, says="gain of servoj")

    motion = MotionModel(
        "ur-rtde-servo",
        corners="streamed",
        unit="rad",
        decimals=6,
        period=PERIOD,
        takes_share=True,
        takes_loads=True,
        takes_outputs=True,
    )

    def _settings(self, options: Any, silence: float, approval: Approval) -> ProgramSettings:
        servo = Servo(options.lookahead_s, options.gain, approval.speed_share)
        return replace(super()._settings(options, silence, approval), servo=servo)
