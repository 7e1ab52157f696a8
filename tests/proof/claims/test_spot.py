"""Where the proof says that a plan is nearest to something, and what is shown for it."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from trimesh.proximity import closest_point_naive

from workbench.app.picking.pipeline import plan_pick
from workbench.formats.meshes.triangles import triangles_of
from workbench.model.plan import Guarantee
from workbench.proof.claims.prove import prove
from workbench.proof.claims.spot import spot_of


def test_the_two_points_are_as_far_apart_as_the_proof_says(cell, result):
    nearest = result.proof.nearest
    spot = spot_of(cell, result.plan, nearest)
    assert np.linalg.norm(spot.points[0] - spot.points[1]) == pytest.approx(nearest.distance)
    assert spot.distance == pytest.approx(nearest.distance)
    assert result.proof.clearance <= nearest.distance


def test_at_that_time_of_the_leg_the_arm_stands_as_it_was_measured(cell, result):
    nearest = result.proof.nearest
    spot, leg = (
        spot_of(cell, result.plan, nearest),
        result.plan.arm(nearest.arm).leg(nearest.leg),
    )
    np.testing.assert_allclose(leg.at(spot.seconds), nearest.q, atol=1e-6)


def test_both_points_are_on_what_is_drawn(cell, result):
    """By trimesh, which knows nothing of joints: bodies are drawn where they were measured."""
    spot = spot_of(cell, result.plan, result.proof.nearest)
    for point in spot.points:
        off = []
        for shape, T_world_body in spot.bodies:
            surface = triangles_of(shape)
            drawn = trimesh.Trimesh(surface.vertices, surface.faces, process=False)
            _, (distance,), _ = closest_point_naive(drawn, [T_world_body.actInv(point)])
            off.append(distance)
        # Round bodies are drawn with corners.
        assert min(off) < 5e-4


def test_a_finding_that_names_no_place_shows_none(cell, result):
    nowhere = replace(result.proof.nearest, pair=None, waypoint=None)
    assert spot_of(cell, result.plan, nowhere) is None


def test_arms_at_any_speeds_are_shown_where_they_are_nearest(cell, detections):
    """Both arms at once: the place that is found is no farther than the proof has measured."""
    result = plan_pick(cell, detections, "both", strategy="coordinated", threshold=0.0)
    assert result.plan.guarantee is Guarantee.TIME_INDEPENDENT
    nearest = prove(cell, result.plan.scene, result.plan).nearest
    spot = spot_of(cell, result.plan, nearest)
    assert spot.distance == pytest.approx(nearest.distance, abs=0.001)
