"""Types for what the workbench uses of Open3D, whose own know no defaults of `Tensor`."""

from open3d import core as core
from open3d import geometry as geometry
from open3d import t as t
from open3d import utility as utility
