"""The shipped TX2-90: its axes are those of the public description, its geometry holds it."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from workbench.formats.cells import read_cell
from workbench.formats.urdf import read_urdf
from workbench.model.geometry import Mesh

PUBLIC = Path(__file__).resolve().parents[3] / "shared" / "data" / "tx2_90"

OUTSIDE = 0.004
"""[m] The most by which a point of the real robot may stand out of our geometry."""

needs_public_data = pytest.mark.skipif(not PUBLIC.is_dir(), reason="no ../shared/data/tx2_90 here")


@needs_public_data
def test_the_axes_are_those_of_the_machine():
    ours, public = read_cell("tx2_90").robot, read_urdf(PUBLIC / "tx2_90.urdf")
    for number in range(1, 7):
        one, other = ours.joint(f"joint_{number}"), public.joint(f"joint_{number}")
        assert one.T_parent_joint.isApprox(other.T_parent_joint, 1e-9)
        np.testing.assert_allclose(one.axis, other.axis)
        np.testing.assert_allclose(
            [one.lower, one.upper, one.velocity], [other.lower, other.upper, other.velocity],
            rtol=1e-6,
        )  # fmt: skip


@needs_public_data
@pytest.mark.parametrize("link", ["base_link", *(f"link_{number}" for number in range(1, 7))])
def test_the_geometry_holds_the_real_link(link):
    surface = trimesh.load_mesh(PUBLIC / "meshes" / "visual" / f"{link}.stl")
    sampled, _ = trimesh.sample.sample_surface(surface, 5000, seed=0)
    points = np.vstack([surface.vertices, sampled])
    depths = []
    for solid in read_cell("tx2_90").robot.link(link).collision:
        assert isinstance(solid.shape, Mesh)
        faces = ConvexHull(solid.shape.points).equations
        depths.append((points @ faces[:, :3].T + faces[:, 3]).max(axis=1))
    assert np.min(depths, axis=0).max() < OUTSIDE
