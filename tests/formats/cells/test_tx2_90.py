"""The shipped TX2-90: its axes are those of the public description, its geometry holds it."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull
from stand_ins import folder_of, make_tx2_90, sources

from workbench.formats.cells.reading import read_cell
from workbench.formats.robots.urdf import read_urdf
from workbench.model.geometry import Mesh

OUTSIDE = 0.004
"""[m] The most by which a point of the real robot may stand out of our geometry."""


@pytest.fixture(scope="module", params=sources("tx2_90"))
def public(request, tmp_path_factory) -> Path:
    """The folder of the description that others made of the machine."""
    return folder_of(request.param, "tx2_90", make_tx2_90, tmp_path_factory.mktemp("tx2_90"))


def test_the_axes_are_those_of_the_machine(public):
    ours, theirs = read_cell("tx2_90").robot, read_urdf(public / "tx2_90.urdf")
    for number in range(1, 7):
        one, other = ours.joint(f"joint_{number}"), theirs.joint(f"joint_{number}")
        assert one.T_parent_joint.isApprox(other.T_parent_joint, 1e-9)
        np.testing.assert_allclose(one.axis, other.axis)
        np.testing.assert_allclose(
            [one.lower, one.upper, one.velocity], [other.lower, other.upper, other.velocity],
            rtol=1e-6,
        )  # fmt: skip


@pytest.mark.parametrize("link", ["base_link", *(f"link_{number}" for number in range(1, 7))])
def test_the_geometry_holds_the_real_link(public, link):
    surface = trimesh.load_mesh(public / "meshes" / "visual" / f"{link}.stl")
    sampled, _ = trimesh.sample.sample_surface(surface, 5000, seed=0)
    points = np.vstack([surface.vertices, sampled])
    # Read by us as well, in the same place.
    (read,) = read_urdf(public / "tx2_90.urdf").link(link).visual
    np.testing.assert_allclose(
        [read.shape.points.min(axis=0), read.shape.points.max(axis=0)], surface.bounds, atol=1e-6
    )
    depths = []
    for solid in read_cell("tx2_90").robot.link(link).collision:
        assert isinstance(solid.shape, Mesh)
        faces = ConvexHull(solid.shape.points).equations
        depths.append((points @ faces[:, :3].T + faces[:, 3]).max(axis=1))
    assert np.min(depths, axis=0).max() < OUTSIDE
