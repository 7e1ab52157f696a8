"""Which pairs of bodies are looked at, and what distance they must keep."""

import threading
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from workbench.model.candidate import Pick
from workbench.model.cell import Fixture
from workbench.model.geometry import Box, Solid
from workbench.model.scan import Detection
from workbench.planning.collision import pairing
from workbench.planning.collision.legs import holding_phase
from workbench.planning.collision.pairing import Pairing
from workbench.planning.collision.world import World
from workbench.planning.picking.propose import propose
from workbench.planning.picking.resolve import resolve


@pytest.mark.parametrize("name", ["right_link_5", "right_tool", "bin"])
def test_a_fixture_is_met_whatever_its_name(cell, name):
    """Also when a link has the same name, or a pair with that link is disabled."""
    chain = World(cell, ()).chains["right"]
    hand = chain.pose(np.asarray(cell.arm("right").home)).translation

    def met(name: str) -> set[frozenset[str]]:
        block = Solid("block", Box(np.full(3, 0.3)), pin.SE3.Identity())
        fixture = Fixture(name, pin.SE3(np.eye(3), hand), (block,))
        world = World(replace(cell, fixtures=(fixture,)), ())
        return {frozenset(one.pair) for one in world.contacts(world.configuration({}))}

    assert met(name) == met("a name of its own")
    assert len(met(name)) > 3


def test_only_the_held_part_may_start_in_contact(cell, detections):
    """A hand that closes on something beside the part is no start of a lift."""
    world = World(cell, detections[:1])
    picks = (resolve(world, c, seed=0) for c in propose(world))
    pick = next(pick for pick in picks if isinstance(pick, Pick))
    arm = cell.arm(pick.candidate.arm)
    hand = world.chains[arm.name].pose(pick.q_grasp).translation
    beside = Detection(detections[0].part, pin.SE3(np.eye(3), hand + [0.0, 0.0, 0.06]))
    world = World(cell, (detections[0], beside))
    world.enter(holding_phase(pick.candidate, arm, pick.T_tcp_part, straight=True))
    q = world.configuration({arm.name: pick.q_grasp})
    before = {one.pair for one in world.contacts(q)}
    assert ("bin_floor", "part-1") in before
    assert any(set(pair) == {f"{arm.name} palm", "part-2"} for pair in before)
    world.allow_start_contacts(q)
    assert {one.pair for one in world.contacts(q)} == {p for p in before if "part-1" not in p}


def test_several_threads_may_make_worlds(cell, detections, monkeypatch):
    """While one takes its pairing, another must not throw it out to make room for its own."""
    taken = threading.Event()

    class Slow(dict):
        def __setitem__(self, key, value):
            super().__setitem__(key, value)
            taken.set()
            threading.Event().wait(0.1)

    monkeypatch.setattr(pairing, "_PAIRINGS", Slow())
    monkeypatch.setattr(pairing, "MOST_PAIRINGS", 1)
    made: list[Pairing] = []

    def make(count: int) -> None:
        made.append(World(cell, detections[:count])._pairing)

    threads = [threading.Thread(target=make, args=(count,)) for count in (0, 1, 2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert taken.is_set() and len(made) == 3
