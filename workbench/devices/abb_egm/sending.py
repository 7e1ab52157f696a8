"""One sending: checks first, then answers each report with a reference; any doubt ends the motion.

The controller's reports are the clock: each is answered by exactly one reference, the next along
the leg.  When reports or answers are lost, the robot is later than planned, but never faster and
never off its path.  Without a new reference the robot stays at the last one.
"""

import select
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace

import numpy as np

from workbench.devices.abb_egm import wire
from workbench.devices.abb_egm.channel import Channel
from workbench.devices.abb_egm.orders import LegRun, Order, Score
from workbench.devices.streamed_way import Ride
from workbench.model.errors import JobCancelled, LinkError, ProtocolError
from workbench.model.geometry import Floats
from workbench.model.messages.devices import DeviceText
from workbench.model.messages.message import Message
from workbench.model.messages.plans import leg_message
from workbench.model.messages.work import LinkText, StopText
from workbench.model.release import LinkStatus, Receipt
from workbench.plugins.progress import Cancelled
from workbench.plugins.robot_link import LinkPatience

START_TOLERANCE = np.deg2rad(0.2)
"""[rad] A joint may stand this far from where the plan begins, or a leg ends."""

FOLLOWING_TOLERANCE = np.deg2rad(1.0)
"""Largest distance [rad] of a joint from its references within `LAG`, also at rest."""

LAG = 25
"""[references] 0.1 s: this far behind may the robot be."""

GENTLE = 50
"""[references] In this many it goes from where it stands to where the plan begins."""

SETTLE = 750
"""[reports] Longest time to come to rest at the end of a leg: 3 s."""

REPORTS_FIRST = 5
"""[reports] Number of reports in order that must come before anything is sent."""

CONNECT = 2.0
"""[s] A controller whose EGM runs is heard at once."""

POLL_EVERY = 0.05
SHOWN_EVERY = 25
"""[reports] Interval of the status for people."""


class EgmSending:
    """One conversation, by the channels of the arms that take part.

    `share` is that of the planned speed, and `silence` [s] is how old a report may be when it is
    answered.
    """

    def __init__(
        self,
        channels: Mapping[str, Channel],
        score: Score,
        share: float,
        silence: float,
        *,
        now: Callable[[], float],
        show: Callable[[LinkStatus], None],
        patience: LinkPatience,
    ) -> None:
        self._channels, self._score = channels, score
        self._share, self._silence = share, silence
        self._now, self._show, self._patience = now, show, patience
        self._refs: dict[str, deque[Floats]] = {}
        self._orders: dict[str, wire.ModuleOrder] = {}
        # Of each arm: the order said last, that which has gone out, and that which is done.
        self._count, self._given, self._done_by = (dict.fromkeys(channels, 0) for _ in range(3))
        self._riding: tuple[str, Ride] | None = None
        self._done, self._leg, self._reports = 0, 0, 0
        # Arms whose module has ended: EGM stops there, and nothing more is said to it.
        self._ended: set[str] = set()

    def run(self, released: Callable[[], None], cancelled: Cancelled) -> Iterator[Receipt]:
        """Look, stream, follow.

        Args:
            released: called before anything is sent; raises when the approval does not hold.
            cancelled: whether to stop.

        Raises:
            LinkError: the robot is not ready, stands elsewhere, does not follow, or is not heard.
            JobCancelled: somebody stops; says whether the robot stands.
        """
        self._look(cancelled)
        released()
        has_ended = False
        try:
            for number, item in enumerate(self._score.items, start=1):
                work = self._ride(item) if isinstance(item, LegRun) else self._order(item)
                for _ in work:
                    if cancelled():
                        has_ended = True
                        self._stop()
                self._done = number
                # Whoever takes this does it while the robot stands.
                yield self._receipt(item)
            has_ended = True
            self._report("ended")
        finally:
            if not has_ended:
                with suppress(LinkError):
                    self._come_to_rest()

    @property
    def _where(self) -> Message:
        legs = sum(isinstance(item, LegRun) for item in self._score.items)
        return DeviceText.LEG(number=self._leg, total=legs)

    def _look(self, cancelled: Cancelled) -> None:
        """Nothing is sent before every arm has reported in order and may move."""
        until = self._patience.clock() + min(CONNECT, self._patience.answer)
        heard = dict.fromkeys(self._channels, 0)
        trouble: Message | None = None
        while min(heard.values()) < REPORTS_FIRST:
            if cancelled():
                raise JobCancelled(LinkText.NOTHING_SENT())
            if self._patience.clock() > until:
                arm = min(heard, key=lambda name: heard[name])
                raise LinkError(trouble or DeviceText.NO_REPORTS(arm=arm))
            select.select(list(self._channels.values()), [], [], POLL_EVERY)
            for name, channel in self._channels.items():
                try:
                    if channel.hear_first():
                        heard[name] += len(channel.came)
                except LinkError as error:
                    # A module that nobody answers takes up EGM anew, and its numbers begin anew.
                    heard[name], trouble = 0, error.message
                    channel.forget()
        for name, channel in self._channels.items():
            feedback = channel.last
            assert feedback is not None
            self._check_state(name, feedback)
            self._check_new(name, wire.module_of(name, feedback))
            self._check_stands(name, self._score.start(name).at(0.0)[0], DeviceText.PLAN_START())
            self._refs[name] = deque([channel.q], maxlen=LAG)
            self._orders[name] = wire.ModuleOrder(self._score.ticket)

    def _order(self, order: Order) -> Iterator[None]:
        """Say it until the module says that it has done it."""
        number = self._count[order.arm] = self._count[order.arm] + 1
        self._orders[order.arm] = wire.ModuleOrder(
            self._score.ticket,
            number,
            order.command,
            order.opening * 1000,
            order.holding,
            load=order.load,
        )
        began, beside = self._patience.clock(), 0
        start, goal = self._refs[order.arm][-1], self._score.start(order.arm).at(0.0)[0]
        is_done = False
        while not is_done:
            for name in self._hear():
                if name != order.arm:
                    self._answer(name, self._refs[name][-1])
                    continue
                if order.command == wire.BEGIN and beside < GENTLE:
                    beside += 1
                    self._answer(name, start + (goal - start) * beside / GENTLE)
                else:
                    self._answer(name, self._refs[name][-1])
                is_begun = order.command != wire.BEGIN or beside == GENTLE
                is_done = is_begun and self._done_by[name] == number
            yield
            if self._patience.clock() - began > self._patience.answer:
                raise LinkError(DeviceText.NOT_DONE(arm=order.arm, order=order.words))
        if order.command == wire.END:
            self._ended.add(order.arm)

    def _check_new(self, name: str, module: wire.ModuleReport) -> None:
        """The module in RAPID has not begun this plan before: neither last, nor before others."""
        has_begun = module.ticket == self._score.ticket and not self._given[name]
        if has_begun or module.refused == self._score.ticket:
            raise LinkError(DeviceText.RUN_BEFORE())

    def _check_module(self, name: str, feedback: wire.Feedback) -> None:
        """The module in RAPID reports our ticket, and of no order but the last ones."""
        module = wire.module_of(name, feedback)
        self._check_new(name, module)
        before, given = self._done_by[name], self._given[name]
        if module.ticket != self._score.ticket:
            if before:
                raise ProtocolError(f"{name}: the module in RAPID has begun another plan")
            return
        if module.done not in (before, given):
            raise ProtocolError(
                f"{name}: the module in RAPID reports order {module.done:.6g}, where {before} was "
                f"done and {given} was given"
            )
        self._done_by[name] = int(module.done)

    def _ride(self, run: LegRun) -> Iterator[None]:
        """One reference for each report, then wait until the arm stands there."""
        self._leg = run.number
        ride = Ride(run.way, self._share, wire.PERIOD_MS / 1000)
        self._orders[run.arm] = replace(self._orders[run.arm], leg=run.number)
        self._check_stands(run.arm, ride.q, DeviceText.LEG_START(leg=leg_message(run.name)))
        self._riding = run.arm, ride
        settled, is_there, has_begun = 0, False, False
        while not is_there:
            for name in self._hear():
                if name != run.arm:
                    self._answer(name, self._refs[name][-1])
                    continue
                # Before it sets out, whoever took the last receipt may have taken a while.
                if has_begun:
                    self._check_late(name)
                has_begun = True
                if not ride.is_over:
                    self._answer(name, ride.go())
                    continue
                self._answer(name, ride.q)
                settled += 1
                is_there = self._is_there(name)
                if settled > SETTLE:
                    end = DeviceText.LEG_END(leg=leg_message(run.name))
                    self._check_stands(name, ride.q, end)
                    raise LinkError(DeviceText.NOT_AT_REST(arm=name, where=end))
            yield
        self._riding = None
        self._orders[run.arm] = replace(self._orders[run.arm], leg=0)

    def _hear(self) -> list[str]:
        """Arms with new reports, each of which is checked."""
        heard: list[str] = []
        for name, reports in self._news():
            for feedback in reports:
                self._check_state(name, feedback)
                self._check_module(name, feedback)
                self._check_follows(name, feedback)
            heard.append(name)
            self._reports += 1
            if self._reports % SHOWN_EVERY == 1:
                self._report("running" if self._riding is not None else "waiting")
        return heard

    def _open_ones(self, silent: Mapping[str, LinkError]) -> dict[str, Channel]:
        """The channels of arms that neither have ended nor are silent."""
        gone = self._ended | silent.keys()
        return {name: channel for name, channel in self._channels.items() if name not in gone}

    def _news(
        self, silent: dict[str, LinkError] | None = None
    ) -> Iterator[tuple[str, list[wire.Feedback]]]:
        """What was reported since, within a moment, of the arms that have not ended.

        Raises:
            LinkError: an arm is silent, also while others report; where `silent` is given, it is
                noted there instead, and the arm is left out.
        """
        open_ones = self._open_ones(silent or {})
        select.select(list(open_ones.values()), [], [], POLL_EVERY)
        for name, channel in open_ones.items():
            try:
                is_new = channel.hear() is not None
            except LinkError as error:
                if silent is None:
                    raise
                silent[name] = error
                continue
            if is_new:
                yield name, channel.came

    def _check_state(self, name: str, feedback: wire.Feedback) -> None:
        if feedback.fault:
            where = self._where if self._leg else DeviceText.PLAN_START()
            raise LinkError(DeviceText.FAULT(where=where, fault=f"{name}: {feedback.fault}"))

    def _check_late(self, name: str) -> None:
        late = self._channels[name].late
        if late > self._silence:
            raise LinkError(DeviceText.LATE(late=late, where=self._where))

    def _check_follows(self, name: str, feedback: wire.Feedback) -> None:
        """An arm is near its last references, also one that is to stand where it is."""
        q = self._channels[name].q_of(feedback)
        off = np.abs(np.array(self._refs[name]) - q).max(axis=1).min()
        if not off <= FOLLOWING_TOLERANCE:
            raise LinkError(DeviceText.NOT_FOLLOWING(name=name, off=float(off), where=self._where))

    def _check_stands(self, name: str, q: Floats, where: Message) -> None:
        channel = self._channels[name]
        off = np.abs(channel.q - q)
        if not off.max() <= START_TOLERANCE:
            joint = channel.arm.joints[int(off.argmax())]
            raise LinkError(DeviceText.OFF_TARGET(joint=joint, off=float(off.max()), where=where))

    def _is_there(self, name: str) -> bool:
        feedback = self._channels[name].last
        off = np.abs(self._channels[name].q - self._refs[name][-1]).max()
        return feedback is not None and feedback.is_converged and bool(off <= START_TOLERANCE / 2)

    def _answer(self, name: str, q: Floats) -> None:
        self._refs[name].append(q)
        order = self._orders[name]
        self._channels[name].answer(q, order.numbers)
        self._given[name] = order.number

    def _stop(self) -> None:
        """Brake on the way, and wait for the report that the robot stands.

        Raises:
            JobCancelled: always.
        """
        began = self._patience.clock()
        stands, missing = False, StopText.NOT_STANDING()
        try:
            stands = self._come_to_rest()
        except LinkError as error:
            missing = StopText.SINCE(what=missing, why=error.message)
        if not stands:
            raise JobCancelled(StopText.AT(where=self._where, how=missing))
        took = self._patience.clock() - began
        words = StopText.STANDS(took=took)
        self._report("stopped", took, words)
        raise JobCancelled(StopText.AT(where=self._where, how=words))

    def _come_to_rest(self) -> bool:
        """Slow down along the way, then end EGM; whether every arm was reported to stand.

        A robot that may not move is sent no new place, and none is sent where nothing is heard: a
        silent arm is an error once the others rest.
        """
        if self._riding is not None:
            self._riding[1].brake()
        ends_at, silent = self._patience.clock() + self._patience.stop, dict[str, LinkError]()
        while self._open_ones(silent) and self._patience.clock() < ends_at:
            for name, reports in self._news(silent):
                for feedback in reports:
                    self._check_state(name, feedback)
                if self._slow_down(name):
                    self._ended.add(name)
        for error in silent.values():
            raise error
        return len(self._ended) == len(self._channels)

    def _slow_down(self, name: str) -> bool:
        """One more reference, or the order to end; whether the arm stands and has ended."""
        q = self._refs[name][-1]
        if self._riding is not None and self._riding[0] == name and not self._riding[1].is_over:
            self._answer(name, self._riding[1].go())
            return False
        if not self._is_there(name):
            self._answer(name, q)
            return False
        feedback = self._channels[name].last
        module = None if feedback is None else feedback.module
        command, ticket = self._orders[name].command, self._score.ticket
        if command == wire.NONE or (module is not None and module.refused == ticket):
            return True
        if command == wire.BEGIN and not self._has_done_all(name):
            # A module that has not begun does not know of an end.
            self._answer(name, q)
            return False
        if command != wire.END:
            self._count[name] += 1
            self._orders[name] = wire.ModuleOrder(ticket, self._count[name], wire.END)
        self._answer(name, q)
        return self._has_done_all(name)

    def _has_done_all(self, name: str) -> bool:
        feedback = self._channels[name].last
        module = None if feedback is None else feedback.module
        if module is None:
            return False
        return (module.ticket, module.done) == (self._score.ticket, self._count[name])

    def _report(
        self, phase: str, stopped: float | None = None, stop: Message | None = None
    ) -> None:
        joints = {name: channel.q for name, channel in self._channels.items()}
        legs, at = sum(isinstance(item, LegRun) for item in self._score.items), self._now()
        heard = f"leg {self._leg}"
        self._show(
            LinkStatus("abb-egm", phase, self._leg, legs, heard, at, at, stopped, stop, joints)
        )

    def _receipt(self, item: Order | LegRun) -> Receipt:
        at, total = self._now(), self._score.total
        if isinstance(item, Order):
            words = item.words
            return Receipt(at, item.arm, "order", words, self._done, total, f"done: {words}")
        sent = f"{item.way.seconds / self._share:.3f} s of references"
        return Receipt(at, item.arm, item.name, sent, self._done, total, "at rest")
