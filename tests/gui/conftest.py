"""The YuMi cell with two parts found and planned for, and states of every phase."""

import time
from contextlib import nullcontext
from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest
from idle import Idle

import workbench.gui.shared.visitor
from workbench.app.core.cycle.approval import approve
from workbench.app.core.people import Person, Role
from workbench.app.core.state import Job, Phase, State
from workbench.app.picking.pipeline import plan_pick
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.live import Live
from workbench.formats.cells.reading import read_cell
from workbench.gui.shared.look import Look, SharedLook, View
from workbench.gui.shared.playback import timeline
from workbench.gui.shared.viser_server import close_viser, open_viser
from workbench.gui.shared.visitor import Visitor
from workbench.journal.journal import Journal
from workbench.model.cell import Cell
from workbench.model.geometry import pose_from_rpy
from workbench.model.plan import PlanResult, Proven
from workbench.model.release import Receipt
from workbench.model.scan import Detection, Scan

NOW = 1_760_000_000.0


@dataclass(frozen=True)
class States:
    """A state of each phase, all of the same cycle."""

    idle: State
    scanned: State
    localized: State
    planned: State
    approved: State
    sending: State
    done: State
    fault: State
    planning: State

    @property
    def all(self) -> tuple[State, ...]:
        return tuple(getattr(self, name) for name in self.__dataclass_fields__)


@pytest.fixture(scope="session")
def cell() -> Cell:
    return read_cell("yumi")


@pytest.fixture(scope="session")
def scan(cell: Cell) -> Scan:
    """A grid of points on the bin's floor."""
    T_world_bin = cell.bin.T_world_bin
    length, width, _ = cell.bin.size
    x, y = np.meshgrid(np.linspace(-length, length, 60), np.linspace(-width, width, 60))
    p_bin = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    p_world = p_bin @ T_world_bin.rotation.T + T_world_bin.translation
    T_scanner_world = cell.scanner.T_world_scanner.inverse()
    points = p_world @ T_scanner_world.rotation.T + T_scanner_world.translation
    return Scan(points, cell.scanner.T_world_scanner, "a drawn floor", at=NOW)


@pytest.fixture(scope="session")
def detections(cell: Cell) -> tuple[Detection, ...]:
    """Two cylinders lying on the bin's floor, apart from each other and from the walls."""
    floor, height = cell.bin.T_world_bin.translation, 0.0191
    places = ((-0.01, -0.07, 0.4), (0.01, 0.07, -0.6))
    return tuple(
        Detection(
            "keyed_cylinder",
            pose_from_rpy(floor + np.array([x, y, height]), (np.pi / 2, 0.0, yaw)),
            0.9,
        )
        for x, y, yaw in places
    )


@pytest.fixture(scope="session")
def result(cell: Cell, scan: Scan, detections: tuple[Detection, ...]) -> PlanResult:
    result = plan_pick(cell, detections, scan.digest, seed=0)
    assert result.plan is not None and result.proof is not None and result.proof.holds
    return result


@pytest.fixture(scope="session")
def states(cell: Cell, scan: Scan, detections, result: PlanResult) -> States:
    idle = State(cell)
    scanned = replace(idle, phase=Phase.SCANNED, scan=scan, scene_digest=scan.digest)
    localized = replace(scanned, phase=Phase.LOCALIZED, detections=detections)
    planned = replace(
        localized,
        phase=Phase.PLANNED,
        candidates=result.candidates,
        plan=result.plan,
        proof=result.proof,
        verdict=result.verdict,
        seconds=tuple(result.seconds.items()),
    )
    approval = approve(cell, result.plan, result.proof, "Anna", NOW)
    approved = replace(planned, phase=Phase.APPROVED, approval=approval)
    receipt = Receipt(NOW + 1, "right", "in", "inR#*1.00*2.00*", 3, 40)
    sending = replace(approved, phase=Phase.SENDING, receipts=(receipt,))
    return States(
        idle=idle,
        scanned=scanned,
        localized=localized,
        planned=planned,
        approved=approved,
        sending=sending,
        done=replace(sending, phase=Phase.DONE, parts_placed=2, is_over=True),
        fault=replace(sending, phase=Phase.FAULT, fault="the controller closed the link"),
        planning=replace(localized, job=Job(7, "plan"), message="planning"),
    )


@pytest.fixture(scope="session")
def row(states: States) -> State:
    """Three plans in a row, each for two of six parts; the second one comes nearest to anything."""
    planned = states.planned
    lying = tuple(
        replace(one, T_world_part=pin.SE3(one.T_world_part.rotation, place))
        for place in (np.array([0.5, 0.1 * number, 0.1]) for number in range(2))
        for one in planned.plan.detections
    )
    every = (*planned.plan.detections, *lying)
    near = replace(planned.proof.nearest, pair=("part-1", "bin_wall_left"))
    plans = [replace(planned.plan, detections=every[first:]) for first in (0, 2, 4)]
    proofs = [
        replace(planned.proof, plan_digest=plans[0].digest),
        replace(planned.proof, plan_digest=plans[1].digest, clearance=0.0021, nearest=near),
        replace(planned.proof, plan_digest=plans[2].digest),
    ]
    first, *after = (Proven(*one) for one in zip(plans, proofs, strict=True))
    return replace(planned, detections=every, plan=first.plan, proof=first.proof, row=tuple(after))


@pytest.fixture(scope="session")
def view_of():
    """Makes the view of a state, looked at from the start of its plan."""

    def make(state: State, look: Look | None = None, live: Live | None = None) -> View:
        runs = timeline(*state.plans)
        return View(state, live or Live(), look or Look(), runs, NOW)

    return make


@pytest.fixture(autouse=True)
def in_utc(monkeypatch):
    monkeypatch.setenv("TZ", "UTC")
    time.tzset()
    yield
    monkeypatch.undo()
    time.tzset()


@pytest.fixture
def bench(cell, tmp_path):
    """That records and decides, and moves nothing."""
    bench = Bench(cell, Journal(tmp_path), effects=Idle)
    yield bench
    bench.close()


@pytest.fixture
def visitor(bench, monkeypatch):
    """Somebody at a page whose controls nobody sees, with what was told."""
    server = open_viser("127.0.0.1", 0)
    monkeypatch.setattr(
        workbench.gui.shared.visitor, "person_of", lambda _: Person("Ada", Role.ENGINEER)
    )
    monkeypatch.setattr(workbench.gui.shared.visitor, "language_of", lambda _: "en")
    told = []
    client = SimpleNamespace(
        client_id=1,
        gui=server.gui,
        scene=server.scene,
        atomic=nullcontext,
        camera=SimpleNamespace(update_timestamp=0.0),  # the browser has said nothing of it yet
        told=told,
        add_notification=lambda title, text, **_: told.append(text),
    )
    visitor = Visitor(client, bench, SharedLook(lambda: None))
    yield visitor
    visitor.end(is_gone=True)
    close_viser(server)
