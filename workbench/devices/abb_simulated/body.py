"""The robot of a simulated controller: where its arms stand, what its hands hold, what it did."""

import json
import threading
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from workbench.devices.abb_loads import LoadData
from workbench.devices.abb_simulated.faults import Faults
from workbench.devices.abb_socket.program import LoadOf
from workbench.model.cell import Arm, Cell
from workbench.model.errors import LinkError
from workbench.model.geometry import Floats, shift_and_turn
from workbench.model.tools.slots import with_mounted

IN_SLOT, IN_SLOT_TURN = 0.002, np.deg2rad(0.5)
"""[m, rad] How far a flange may be off a slot where a tool is coupled."""


class SimulatedBody:
    """Arms and hands.

    Lifetime: as long as the controller.
    Concurrency: the thread that serves the client changes it, another one reads `state`.
    """

    def __init__(
        self, cell: Cell, speed: float, record: Path | None, trace: Path | None, faults: Faults
    ) -> None:
        """All arms stand at home.

        Args:
            cell: whose arms.
            speed: 1 is real time.
            record: file for what arrives, see `record`.
            trace: file for what is executed, see `trace`.
            faults: that are to come.
        """
        self.cell, self.speed, self.faults = cell, speed, faults
        self.is_traced = trace is not None
        self._record, self._trace = record, trace
        self._lock = threading.Lock()
        self._q: dict[str, Floats] = {arm.name: np.array(arm.home) for arm in cell.arms}
        self._openings = {arm.name: 0.0 for arm in cell.arms}
        self._holds: dict[str, str] = {}
        self._moving, self._fault = "", ""
        self._received = self._placed = self._grips = 0
        self._told: Mapping[tuple[str, LoadOf], LoadData] = {}
        self.carried: dict[str, tuple[LoadData, ...]] = {}
        """What each arm carries that was reported: its tool, and the part in its hand."""

    def state(self) -> dict[str, Any]:
        """As it is reported."""
        with self._lock:
            return {
                "joints": {arm: q.tolist() for arm, q in self._q.items()},
                "openings": dict(self._openings),
                "moving": self._moving,
                "received": self._received,
                "placed": self._placed,
                "fault": self._fault,
            }

    def standing(self) -> dict[str, Floats]:
        """The configuration (n,) [rad] of every arm."""
        with self._lock:
            return dict(self._q)

    def count_message(self) -> None:
        """Count a message."""
        with self._lock:
            self._received += 1

    def record(self, arm: str, kind: str, path: Floats | None) -> None:
        """Write configurations (m, n) [rad] that came to the record."""
        if self._record is not None and path is not None:
            rows = np.atleast_2d(path).tolist()
            _append(self._record, ({"arm": arm, "kind": kind, "q": q} for q in rows))

    def trace(self, states: Iterable[Mapping[str, Any]]) -> None:
        """Write states that the arms went through to the trace."""
        if self._trace is not None:
            _append(self._trace, states)

    def put(self, q: Mapping[str, Floats], moving: str) -> None:
        """Arms stand at `q`, (n,) [rad] each, now, and those named move."""
        with self._lock:
            self._q.update(q)
            self._moving = moving

    def halt(self, fault: str) -> None:
        """Nothing moves any more; `fault` says why, of several the first; empty ends them."""
        with self._lock:
            self._moving, self._fault = "", (self._fault or fault) if fault else ""

    def step_home(self, most: float) -> None:
        """Bring every arm nearer to its home, no joint by more than `most` [rad].

        Once all are there, a fault is over, and hands hold nothing.
        """
        with self._lock:
            for arm in self.cell.arms:
                way = np.asarray(arm.home) - self._q[arm.name]
                self._q[arm.name] = self._q[arm.name] + np.clip(way, -most, most)
            away = [arm.name for arm in self.cell.arms if not self._is_home(arm)]
            self._moving = " and ".join(away)
            if not away:
                self._fault = ""
                self._holds.clear()

    def is_home(self) -> bool:
        """Whether all arms stand at home."""
        with self._lock:
            return all(self._is_home(arm) for arm in self.cell.arms)

    def _is_home(self, arm: Arm) -> bool:
        return bool(np.abs(self._q[arm.name] - np.asarray(arm.home)).max() < 1e-9)

    def reckon(self, loads: Mapping[tuple[str, LoadOf], LoadData]) -> None:
        """Take the loads of a program; hands are empty before it."""
        self._told = loads
        for arm, what in loads:
            if what == "tool":
                self._carry(arm, holding=False)

    def _carry(self, arm: str, *, holding: bool) -> None:
        kinds: tuple[LoadOf, ...] = ("tool", "part") if holding else ("tool",)
        if (arm, "tool") in self._told:
            self.carried[arm] = tuple(self._told[arm, k] for k in kinds if (arm, k) in self._told)

    def open(self, arm: str, opening: float) -> str | None:
        """Open a hand to `opening` [m]; what became of its part, None when it had not closed.

        The words are `picked`, or `missed` and why.
        """
        with self._lock:
            self._openings[arm] = opening
            self._carry(arm, holding=False)
            result = self._holds.pop(arm, None)
            self._placed += result == "picked"
            return result

    def grip(self, arm: str, opening: float) -> None:
        """Close a hand around what should be `opening` [m] wide there."""
        with self._lock:
            self._grips += 1
            self._carry(arm, holding=True)
            if self.faults.is_due("empty-hand", self._grips):
                self._openings[arm] = self.cell.arm(arm).tool.stroke[0]
                closed = f"{self._openings[arm] * 1000:.1f}"
                self._holds[arm] = (
                    f"missed closed to {closed} mm where {opening * 1000:.1f} mm were expected"
                )
            else:
                self._openings[arm] = opening
                self._holds[arm] = "picked"

    def uncouple(self, arm: str) -> None:
        """Leave the tool of an arm in its slot.

        Raises:
            LinkError: the flange is not there, or carries no tool.
        """
        with self._lock:
            carried = self.cell.arm(arm).tool.name
            if self._slot_at(arm) != carried or not carried:
                raise LinkError(f"arm {arm} would drop {carried or 'nothing'}: not in its slot")
            self.cell = with_mounted(self.cell, arm, "")
            self.carried[arm] = ()

    def couple(self, arm: str, opening: float) -> None:
        """Take the tool in whose slot the flange of an arm is, and open it to `opening` [m].

        Raises:
            LinkError: there is none, or the arm carries a tool.
        """
        with self._lock:
            tool = self._slot_at(arm)
            if not tool or self.cell.arm(arm).tool.name:
                raise LinkError(f"arm {arm} has no tool to couple where it stands")
            self.cell = with_mounted(self.cell, arm, tool)
            self._openings[arm] = opening
            if (arm, "next") in self._told:
                self.carried[arm] = (self._told[arm, "next"],)

    def _slot_at(self, name: str) -> str:
        """The tool in whose slot the flange of an arm is; empty where it is in none."""
        arm = self.cell.arm(name)
        values = dict(zip(arm.joints, map(float, self._q[name]), strict=True))
        T_world_flange = self.cell.T_world_robot * self.cell.robot.link_poses(values)[arm.flange]
        for slot in arm.tool_slots:
            shift, turn = shift_and_turn(slot.T_world_flange.actInv(T_world_flange))
            if shift <= IN_SLOT and turn <= IN_SLOT_TURN:
                return slot.tool
        return ""

    def has_gripped(self, arm: str) -> bool:
        """Whether a hand has closed and not opened since."""
        return arm in self._holds

    def forget(self, arm: str) -> None:
        """A new sequence of an arm begins: what its hand held before is not counted."""
        with self._lock:
            self._holds.pop(arm, None)

    def openings(self) -> dict[str, float]:
        """Of every hand [m]."""
        with self._lock:
            return dict(self._openings)


def _append(path: Path, lines: Iterable[Mapping[str, Any]]) -> None:
    with path.open("a") as file:
        for line in lines:
            file.write(json.dumps(line) + "\n")
