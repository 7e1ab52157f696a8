"""Bodies that are in each other: how deep they are is not taken for less than it is."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.app.picking.pipeline import plan_pick
from workbench.formats.cells.reading import read_cell
from workbench.model.geometry import Cylinder
from workbench.model.messages.proofs import ProofText
from workbench.model.scan import Scene
from workbench.perception.simulation.piles import drop_parts
from workbench.proof.claims.prove import prove
from workbench.proof.claims.scene import scene_bodies
from workbench.proof.claims.table import PairTable, Situation
from workbench.proof.engine.frames import SetExtents, poses
from workbench.proof.engine.robot import tree_of
from workbench.proof.engine.sieve import PairQuery, select_pairs_in_sight, sieve
from workbench.proof.engine.space import Space


@pytest.fixture(scope="module")
def cell():
    return read_cell("tx2_90")


@pytest.fixture(scope="module")
def plan(cell):
    pile = drop_parts([cell.part("puck")] * 2, cell.bin, seed=4)
    return plan_pick(cell, pile, "scan", seed=4).plan


@pytest.mark.parametrize(("longer", "holds"), [(0.0, True), (0.002, True), (0.004, False)])
def test_a_tool_presses_no_deeper_than_its_lip_gives_way(cell, plan, longer, holds):
    """Its cup is longer than the cell said when the plan was made; 3 mm may go into the part."""
    (arm,) = cell.arms
    assert arm.tool.press == pytest.approx(0.003)
    body = tuple(
        replace(solid, shape=Cylinder(solid.shape.radius, solid.shape.length + 2 * longer))
        if solid.name == "cup"
        else solid
        for solid in arm.tool.body
    )
    longer_tool = replace(cell, arms=(replace(arm, tool=replace(arm.tool, body=body)),))
    again = replace(plan, cell_digest=longer_tool.digest)
    proof = prove(longer_tool, Scene(plan.scan_digest, plan.detections, plan.obstacles), again)
    approach = [one for one in proof.violations if one.leg == "approach"]
    assert (not approach) is holds, proof.violations
    if not holds:
        assert approach[0].problem == ProofText.MARGIN(margin=-0.003)


def test_what_is_deep_in_each_other_is_never_left_out(cell, plan):
    """Robots folded into themselves, fixtures and parts: asked for less depth than Coal measures.

    Where Coal finds two bodies deeper in each other than they may be, neither boxes nor directions
    may say otherwise: a depth is the least of all that directions say.
    """
    tree = tree_of(cell)
    bodies = scene_bodies(cell, tree, plan.scene)
    space = Space(tree, bodies, PairTable(cell, tree, bodies))
    rng, deep = np.random.default_rng(8), 0
    pairs = space.table.pairs(Situation(np.ones(tree.model.nq, bool)), space.joints)
    first, second = space.table.first[pairs.rows], space.table.second[pairs.rows]
    hidden = np.zeros(len(pairs.rows), bool)
    sides = np.zeros(len(space.joints), np.int64)
    low, high = tree.model.lowerPositionLimit, tree.model.upperPositionLimit
    for _ in range(300):
        q = rng.uniform(low, high)
        space.look(q)
        depths = np.array([space.distance(int(row)) for row in pairs.rows])
        needs = np.where(depths < -0.001, 0.9 * depths, -1.0)
        asked = PairQuery(first, second, pairs.commons, needs, hidden)
        none = np.zeros((1, len(q)))
        world = poses(space.chain, space.arrays, q[None], none, sides == 0)
        still = SetExtents(none, none[None], np.ones(1, np.int64))
        items = select_pairs_in_sight(asked, 0.1, sides, 1, space.arrays, world)
        told = sieve(
            items, asked, np.zeros(1), np.zeros(1, np.int64), np.zeros(1),
            np.zeros_like(space.normals), space.chain, space.arrays, world, still,
        )  # fmt: skip
        wanted = np.flatnonzero(depths < -0.001)
        deep += len(wanted)
        assert np.isin(wanted, told.items[:, 2]).all()
    assert deep > 200
