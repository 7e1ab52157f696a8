"""Controllers of ABB with RobotWare 7, moved by EGM, as the seam wants them."""

import select
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from dataclasses import dataclass
from typing import TYPE_CHECKING

from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.motion import MotionModel
from workbench.model.plan import Plan
from workbench.model.release import Approval, LinkStatus, Receipt, RobotState
from workbench.plugins.options import option, options_of
from workbench.plugins.progress import Cancelled
from workbench.plugins.robot_link import USUAL, LinkPatience, Running, Simulation, check_approval

if TYPE_CHECKING:
    from workbench.devices.abb_egm.channel import Channel

POLL_EVERY = 0.1
"""[s] Between two looks whether to end."""

MOST_AXES = 7

STANDS_WITHIN = 1e-5
"""[rad] Between two reports; an arm that moved by less stands."""

RECENT = 0.2
"""[s] An arm that moved so lately still moves."""


class AbbEgm:
    """Answers each report of a controller with the next reference along the way."""

    @dataclass(frozen=True)
    class Options:
        """Keys in `[controller.options]`."""

        silence_ms: int = option(
            100, low=20, high=1000, says="without a report for longer the motion ends [ms]"
        )

    motion = MotionModel(
        "abb-egm",
        corners="streamed",
        unit="deg",
        period=0.004,
        takes_share=True,
        takes_loads=True,
        takes_openings=True,
    )

    tells_of_parts = False
    """What became of parts is not reported, only that every order was done."""

    def check(self, cell: Cell) -> None:
        """Arms of six or seven turning joints, each with a UDP port for motion and for states."""
        for arm in cell.arms:
            kinds = {cell.robot.joint(name).kind for name in arm.joints}
            if len(arm.joints) not in (6, MOST_AXES) or kinds != {"revolute"}:
                raise InputError(
                    "the robot link abb-egm moves arms of six or seven turning joints; "
                    f"{arm.name} has {len(arm.joints)} joints"
                )
        ports = cell.controller.port, cell.controller.state_port
        if abs(ports[0] - ports[1]) < len(cell.arms) or max(ports) + len(cell.arms) > 1 << 16:
            raise InputError(
                f"[controller] port = {ports[0]}, state_port = {ports[1]}: abb-egm takes as many "
                "ports from each on as there are arms"
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
        """Stream the plan leg by leg; a receipt for each, and for each order between them."""
        # Every cell that is read loads this module; only who sends needs the library.
        from workbench.devices.abb_egm.channel import Channel, address_of
        from workbench.devices.abb_egm.orders import score_of
        from workbench.devices.abb_egm.sending import EgmSending

        def check_release() -> None:
            check_approval(plan, approval, cell, now())

        check_release()
        self.check(cell)
        silence = options_of(self.Options, cell.controller.options).silence_ms / 1000
        score, host = score_of(cell, plan, approval), address_of(cell.controller.host)
        with ExitStack() as opened:
            channels: dict[str, Channel] = {}
            for k, arm in enumerate(cell.arms):
                if arm.name in score.arms:
                    port = cell.controller.port + k
                    channel = Channel(cell, arm, host, port, silence, patience.clock)
                    channels[arm.name] = opened.enter_context(closing(channel))
            share = approval.speed_share
            talk = EgmSending(
                channels, score, share, silence, now=now, show=show, patience=patience
            )
            yield from talk.run(check_release, cancelled)

    def states(self, cell: Cell, cancelled: Cancelled) -> Iterator[RobotState]:
        """What EGM streams to the ports for states, whenever it has changed."""
        from workbench.devices.abb_egm.channel import Channel, address_of

        self.check(cell)
        host, port = address_of(cell.controller.host), cell.controller.state_port
        with ExitStack() as opened:
            channels = [
                Channel(cell, arm, host, port + k, USUAL.silence, time.monotonic, is_paced=False)
                for k, arm in enumerate(cell.arms)
            ]
            for channel in channels:
                opened.enter_context(closing(channel))
            before: RobotState | None = None
            moved: dict[str, float] = {}
            while not cancelled():
                select.select(channels, [], [], POLL_EVERY)
                # Each one, ready or not: what an arm reported before it fell silent is no state.
                for channel in channels:
                    was, feedback = channel.last, channel.hear()
                    if feedback and was and abs(feedback.axes - was.axes).max() > STANDS_WITHIN:
                        moved[channel.arm.name] = time.monotonic()
                if any(channel.last is None for channel in channels):
                    continue
                state = _state(channels, moved)
                if state != before:
                    before = state
                    yield state

    def serve(self, cell: Cell, simulation: Simulation, ready: Callable[[Running], None]) -> None:
        """The controller's twin, or modules in RAPID; to the ports that are given, or free ones."""
        if simulation.rapid is not None:
            from workbench.devices.abb_egm.rapid_controller import serve_guided

            self.check(cell)
            serve_guided(cell, simulation, ready)
            return
        from workbench.devices.abb_egm.twin import SimulatedEgm

        self.check(cell)
        twin = SimulatedEgm(cell, simulation)
        ready(twin)
        twin.run()


def _state(channels: "list[Channel]", moved: dict[str, float]) -> RobotState:
    """What the last reports say together."""
    joints = {channel.arm.name: tuple(channel.q.tolist()) for channel in channels}
    recent = time.monotonic() - RECENT
    moving = next((name for name, at in moved.items() if at > recent), "")
    faults = [
        f"{channel.arm.name}: {channel.last.fault}"
        for channel in channels
        if channel.last and channel.last.fault
    ]
    return RobotState(joints, {}, moving, 0, 0, ", ".join(faults))
