"""Plans of an arm that carries the scanner, bent in what concerns its views: none is proven."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from arm_scanner_cell import on_arm_cell, with_lower_view
from bent_plans import TOO_NEAR, Bent, between, judge_plans

from workbench.app.empty_hand.view_plan import plan_view
from workbench.app.picking.pipeline import plan_pick
from workbench.model.cell import Cell
from workbench.model.derived.by_view import with_view
from workbench.model.digest import digest_of
from workbench.model.geometry import Box, Solid
from workbench.model.plan import Plan
from workbench.model.robot import ScanPosture
from workbench.model.scan import Scene
from workbench.perception.simulation.piles import pile_of
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.proof.claims.scene import unseen_bin

ARM = "left"

Bend = Callable[[Cell, Plan, np.random.Generator], Bent]


@pytest.fixture(scope="module")
def low() -> Cell:
    """By the lower one of two views."""
    return with_view(with_lower_view(on_arm_cell()), "low")


@pytest.fixture(scope="module")
def plans(low: Cell) -> tuple[Plan, ...]:
    """The arm takes a part from the lower view, and comes there from the other one."""
    found = plan_pick(low, pile_of(low, "", 2, seed=3), digest_of("scan from low"), strategy=ARM)
    path = plan_view(low, start="bin")
    assert found.plan is not None and path.plan is not None
    for result in (found, path):
        assert result.proof is not None and result.proof.holds
    return found.plan, path.plan


def said_for(cell: Cell, plan: Plan) -> Bent:
    """The plan, said to be for that cell and its bin."""
    obstacles = (unseen_bin(cell),) if plan.is_view_plan else plan.obstacles
    bent = replace(plan, cell_digest=cell.digest, obstacles=obstacles)
    return cell, bent.scene, bent


def grown_housing(cell: Cell, plan: Plan, draw: np.random.Generator) -> Bent:
    size = np.array([0.02, 0.02, draw.uniform(0.05, 0.5)])
    at = np.array([draw.uniform(-0.1, 0.1), draw.uniform(-0.15, 0.0), size[2] / 2])
    carrier = cell.scanner.on_arm
    assert carrier is not None
    post = Solid("camera", Box(size), pin.SE3(np.eye(3), at))
    mount = replace(cell.scanner, on_arm=replace(carrier, housing=(post,)))
    return said_for(replace(cell, scanner=mount), plan)


def moved_view(cell: Cell, plan: Plan, draw: np.random.Generator) -> Bent:
    """The view at which the arm stands, or the one that a path begins at, is elsewhere."""
    carrier = cell.scanner.on_arm
    assert carrier is not None
    off = draw.normal(size=len(carrier.view.q)) * 10 ** draw.uniform(-6, -1)
    if plan.is_view_plan and draw.random() < 0.5:
        (other,) = carrier.other_views
        others = (replace(other, q=other.q + off),)
        mount = replace(cell.scanner, on_arm=replace(carrier, other_views=others))
        return said_for(replace(cell, scanner=mount), plan)
    view = ScanPosture(carrier.view.name, carrier.view.q + off, number=carrier.view.number)
    arms = tuple(replace(arm, home=view.q) if arm.name == ARM else arm for arm in cell.arms)
    mount = replace(cell.scanner, on_arm=replace(carrier, view=view))
    return said_for(replace(cell, arms=arms, scanner=mount), plan)


def other_chosen(cell: Cell, plan: Plan, draw: np.random.Generator) -> Bent:
    """The other view is chosen: the arm stands there, and there it has to end."""
    return said_for(with_view(cell, "bin"), plan)


def other_scan(cell: Cell, plan: Plan, draw: np.random.Generator) -> Bent:
    """The scan is one from another view, in which the same parts were found."""
    return cell, replace(plan.scene, scan_digest=digest_of(f"scan {draw.random()}")), plan


BENDS: tuple[Bend, ...] = (grown_housing, moved_view, other_chosen, other_scan)


def refusals(cell: Cell, scene: Scene, plan: Plan) -> Iterator[str]:
    """What speaks against a plan, by what each bend may spoil and without the proof."""
    if scene.scan_digest != plan.scan_digest:
        yield "it was made for another scan"
    carrier, legs = cell.scanner.on_arm, plan.arm(ARM).legs
    assert carrier is not None
    starts = [carrier.view.q]
    if plan.is_view_plan:
        starts = [carrier.home, *(view.q for view in carrier.other_views)]
    begins = min(float(np.abs(legs[0].q[0] - q).max()) for q in starts)
    ends = float(np.abs(legs[-1].q[-1] - carrier.view.q).max())
    if max(begins, ends) > cell.controller.motion.quantum:
        yield "it goes from elsewhere, or to elsewhere"
    yield from touches(cell, plan)


def touches(cell: Cell, plan: Plan) -> Iterator[str]:
    """Whether the scanner's housing comes too near to anything that always stands there."""
    world = World(cell, (), plan.obstacles)
    for leg in plan.arm(ARM).legs:
        world.enter(LegPhase(frozenset({ARM}), {ARM: leg.opening}))
        for q in between(leg.q):
            for contact in world.contacts(world.configuration({ARM: q})):
                margin = min(contact.margin, cell.policy.near_margin)
                if "left camera" in contact.pair and contact.distance < margin - TOO_NEAR:
                    yield f"{contact.pair} are {contact.distance * 1000:.1f} mm apart"
                    return


def test_none_of_200_bent_plans_with_views_is_proven_that_the_judge_refuses(
    low: Cell, plans: tuple[Plan, ...]
) -> None:
    def bend(seed: int) -> Bent:
        draw, made = np.random.default_rng([11, seed]), BENDS[seed % len(BENDS)]
        return made(low, plans[(seed // len(BENDS)) % 2], draw)

    accepted, refused = judge_plans(200, bend, refusals)
    assert accepted > 20 and refused > 120, (accepted, refused)
