"""The housing of a scanner on an arm collides, for the planner and for the proof alike."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.model.cell import Cell
from workbench.model.geometry import Box, Solid
from workbench.model.scan import Scene
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.proof.claims.scene import scene_bodies
from workbench.proof.claims.table import PairTable, Situation
from workbench.proof.engine.robot import tree_of


@pytest.fixture(scope="module")
def cell() -> Cell:
    return read_cell(find("robots", "yumi") / "on_arm.toml")


def with_housing(cell: Cell, size: list[float], at: list[float]) -> Cell:
    carrier = cell.scanner.on_arm
    assert carrier is not None
    solid = Solid("camera", Box(np.array(size)), pin.SE3(np.eye(3), np.array(at)))
    housing = replace(carrier, housing=(solid,))
    return replace(cell, scanner=replace(cell.scanner, on_arm=housing))


def contact_at_view(cell: Cell) -> set[str]:
    world = World(cell, ())
    world.enter(LegPhase(frozenset({"left"}), {"left": cell.arm("left").tool.stroke[1]}))
    contact = world.contact(world.configuration({}))
    return set() if contact is None else set(contact.pair)


def test_at_the_view_of_the_shipped_cell_nothing_touches(cell: Cell) -> None:
    assert contact_at_view(cell) == set()


def test_a_housing_that_reaches_into_a_wall_at_the_view_is_a_contact(cell: Cell) -> None:
    # From the flange down to the bin, as long as a lamp post.
    found = contact_at_view(with_housing(cell, [0.02, 0.02, 0.6], [0.0, -0.2, 0.3]))
    assert "left camera" in found


def test_a_housing_meets_links_of_its_own_arm_but_not_those_it_is_screwed_to(cell: Cell) -> None:
    found = contact_at_view(with_housing(cell, [0.3, 0.3, 0.3], [0.0, 0.0, -0.1]))
    assert "left camera" in found
    assert not found & {"left_link_6", "left_flange"}


def test_the_proof_compares_the_housing_with_everything_but_its_flange_and_itself(
    cell: Cell,
) -> None:
    tree = tree_of(cell)
    bodies = scene_bodies(cell, tree, Scene("", (), ()))
    table = PairTable(cell, tree, bodies)
    moves = np.zeros(tree.model.nq, bool)
    moves[tree.columns["left"]] = True
    joints = np.array([body.joint for body in bodies])
    pairs = table.pairs(Situation(moves), joints)
    met = {frozenset(table.labels(int(row))) for row in pairs.rows}
    of_camera = {label for pair in met if "left camera" in pair for label in pair}
    assert {"left_link_4", "left_link_5", "right_link_6", "tray_left_floor"} <= of_camera
    assert not of_camera & {"left_link_6", "left palm", "left bracket"}
