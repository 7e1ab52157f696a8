"""Checks of the calibrated scanner: trueness by balls of known distances, and the touch test."""

from collections.abc import Callable

import numpy as np
import viser

from workbench.app.core.command import Command
from workbench.app.core.state import State
from workbench.app.core.verifying import LimitChecks, RecordTouch, RemoveCheck, ScanBalls
from workbench.gui.calibration.check_views import touches_html, trueness_html
from workbench.gui.help.groups import group
from workbench.gui.shared.look import View
from workbench.gui.shared.views import line
from workbench.gui.shared.visitor import Visitor
from workbench.model.calibration import BallArtefact, BallScan, Touch
from workbench.model.cell import Arm
from workbench.model.derived.controller_axes import from_shown
from workbench.model.derived.touches import seen_balls
from workbench.model.errors import InputError
from workbench.model.geometry import Floats

PLATE, BAR = "Plate", "Ball bar"

LAID_ANEW = "In simulation each scan finds the balls in another place of the bin."

SCAN_FIRST = "scan the balls first"


def arm_joints(visitor: Visitor, arm: Arm) -> Floats:
    """Where an arm stands (n,) [rad], chain order: as jogged on the page, or as reported.

    Raises:
        InputError: the scanner is real and the controller reports no joints.
    """
    state, own, joints = visitor.bench.state, visitor.own.now, visitor.bench.live.joints
    is_real = state.cell.scanner.source != "simulated"
    if own.jog is not None and not is_real:
        return own.jog[arm.name]
    if all(joint in joints for joint in arm.joints):
        return np.array([joints[joint] for joint in arm.joints])
    if is_real:
        raise InputError("the controller does not report where the robot is")
    return np.asarray(arm.home)


class ChecksGroups:
    """Two groups of controls, the scans and touches, and the verdicts.

    Concurrency: callbacks come from viser's threads and give commands; `show` is the renderer's.
    """

    def __init__(self, visitor: Visitor, plate: Callable[[], BallArtefact]):
        """Add the controls; `plate` gives the plate of the calibration."""
        self._visitor, self._plate = visitor, plate
        self._shown: tuple[object, ...] = ()
        gui = visitor.gui
        with group(gui, "5 · Trueness", expand_by_default=False):
            self._kind = gui.add_dropdown(
                "Artefact",
                (PLATE, BAR),
                hint="Balls at known distances that lie in the bin: the plate above, or two balls.",
            )
            self._ball = gui.add_number(
                "Bar's ball diameter [mm]",
                30.0,
                min=4,
                max=400,
                step=0.001,
                visible=False,
                hint="Of both balls, as certified.",
            )
            self._bar = gui.add_number(
                "Bar's length [mm]",
                150.0,
                min=8,
                max=5000,
                step=0.001,
                visible=False,
                hint="Centre to centre, as certified.",
            )
            self._limit = gui.add_number(
                "Limit [mm]",
                0.3,
                min=0.01,
                max=100,
                step=0.01,
                hint="Largest sphere-spacing error that is good.",
            )
            gui.add_html('<div class="wb-buttons wb-two"></div>')
            self._scan = gui.add_button("Scan the balls", icon=viser.Icon.SCAN)
            self._drop_scan = gui.add_button("Remove last scan", color="gray")
            simulated = visitor.cell.scanner.source == "simulated"
            gui.add_html(line(LAID_ANEW, kind="hint") if simulated else "")
            self._trueness = gui.add_html("")
        with group(gui, "6 · Touch test", expand_by_default=False):
            self._arm = gui.add_dropdown(
                "Arm",
                tuple(arm.name for arm in visitor.cell.arms),
                visible=len(visitor.cell.arms) > 1,
                hint="Whose tool touches the ball.",
            )
            self._seat = gui.add_number(
                "Hole of the tip [mm]",
                0.0,
                min=0,
                max=400,
                step=0.01,
                hint="Inner diameter of a hollow tip, which centres on the ball; 0: a point.",
            )
            self._joints = gui.add_text(
                "Joints [deg]",
                "",
                hint="As the pendant shows them, axis 1 first; empty: as the controller reports.",
            )
            self._touch_limit = gui.add_number(
                "Limit [mm]",
                0.0,
                min=0,
                max=100,
                step=0.1,
                hint="Largest offset that is good; 0: as the calibration predicts.",
            )
            gui.add_html('<div class="wb-buttons wb-two"></div>')
            self._jog = gui.add_button(
                "Show a touch",
                icon=viser.Icon.BULB,
                color="gray",
                hint="Jogs the robot on the page alone to where its tip touches the next ball.",
            )
            self._touch = gui.add_button("Record the touch", icon=viser.Icon.HAND_FINGER)
            self._drop_touch = gui.add_button("Remove last touch", color="gray")
            self._touches = gui.add_html("")
        self._react()

    def _react(self) -> None:
        visitor = self._visitor

        def state() -> State:
            return visitor.bench.state

        visitor.on_press(self._scan, self._wanted_scan)
        visitor.on_press(
            self._drop_scan, lambda: RemoveCheck(_last(visitor.bench.state.ball_scans))
        )
        visitor.on_press(self._touch, self._wanted_touch)
        visitor.on_press(self._drop_touch, lambda: RemoveCheck(_last(state().touches)))
        self._jog.on_click(lambda _: self._jog_to_ball())
        self._kind.on_update(lambda _: self._choose_kind())
        for control in (self._limit, self._touch_limit):
            visitor.by_hand(control, lambda _: self._state_limits())

    def show(self, new: View) -> None:
        """Bring scans, touches and verdicts up to date."""
        state = new.state
        scans, touches = state.ball_scans, state.touches
        admit = self._visitor.admit
        admit(self._scan, state, ScanBalls)
        admit(self._drop_scan, state, RemoveCheck, otherwise="" if scans else SCAN_FIRST)
        admit(self._touch, state, RecordTouch, otherwise="" if scans else SCAN_FIRST)
        admit(self._jog, state, RecordTouch, otherwise="" if scans else SCAN_FIRST)
        untouched = "" if touches else "record a touch first"
        admit(self._drop_touch, state, RemoveCheck, otherwise=untouched)
        known = (state.cell, scans, touches, state.check_limits)
        if len(known) == len(self._shown) and all(map(_is, known, self._shown)):
            return
        self._shown = known
        self._show_limits(state)
        words = self._visitor.words
        self._trueness.content = trueness_html(scans, state.check_limits[0], words)
        self._touches.content = touches_html(state, words)

    def _show_limits(self, state: State) -> None:
        limits = zip((self._limit, self._touch_limit), state.check_limits, strict=True)
        for control, limit in limits:
            if control.value != round(limit * 1000, 5):
                control.value = round(limit * 1000, 5)

    def _state_limits(self) -> None:
        """State both limits; where that is refused the fields show those that hold."""
        if not self._visitor.ask(self._wanted_limits):
            self._show_limits(self._visitor.bench.state)

    def _choose_kind(self) -> None:
        is_bar = self._kind.value == BAR
        self._ball.visible = self._bar.visible = is_bar

    def _wanted_limits(self) -> Command:
        return LimitChecks(float(self._limit.value) / 1000, float(self._touch_limit.value) / 1000)

    def _wanted_scan(self) -> Command:
        artefact = self._plate()
        if self._kind.value == BAR:
            length = np.array([self._bar.value]) / 1000
            artefact = BallArtefact(float(self._ball.value) / 2000, length)
        return ScanBalls(artefact, seed=self._visitor.bench.state.number)

    def _wanted_touch(self) -> Command:
        state, seat = self._visitor.bench.state, float(self._seat.value) / 1000
        arm = state.cell.arm(self._arm.value)
        typed = self._joints.value.replace(",", " ").split()
        q = self._typed_joints(state, arm, typed) if typed else arm_joints(self._visitor, arm)
        return RecordTouch(_last(state.ball_scans), arm.name, q, seat)

    def _typed_joints(self, state: State, arm: Arm, typed: list[str]) -> Floats:
        try:
            shown = np.array([float(value) for value in typed])
        except ValueError:
            raise InputError("joints are numbers with blanks or commas between them") from None
        if len(shown) != len(arm.joints):
            raise InputError("a joint is missing, or there are too many: one for each axis")
        return from_shown(state.cell, arm, shown)

    def _jog_to_ball(self) -> None:
        self._visitor.attempt(self._show_touch)

    def _show_touch(self) -> None:
        """Jog to the next ball of the last scan; in simulation to where the ball truly lies."""
        # Open3D takes a second to load: the page does not wait for it.
        from workbench.app.calibration.simulated_checks import simulated_place, touching_joints

        visitor, state = self._visitor, self._visitor.bench.state
        if not state.ball_scans:
            raise InputError(SCAN_FIRST)
        cell, scan = state.cell, state.ball_scans[-1]
        arm, count = cell.arm(self._arm.value), sum(t.scan == scan.name for t in state.touches)
        balls = seen_balls(cell, scan)
        if cell.scanner.source == "simulated":
            T = simulated_place(cell, scan.artefact, scan.seed)
            balls = scan.artefact.centres @ T.rotation.T + T.translation
        ball, seat = balls[count % len(balls)], float(self._seat.value) / 1000
        q = touching_joints(cell, arm, ball, scan.artefact.radius, seat, seed=count)
        jog = {other.name: np.asarray(other.home) for other in cell.arms} | {arm.name: q}
        visitor.turn_away()
        visitor.own.change(jog=jog, observation=None)


def _is(one: object, other: object) -> bool:
    return one is other


def _last(known: tuple[BallScan | Touch, ...]) -> str:
    if not known:
        raise InputError(SCAN_FIRST)
    return known[-1].name
