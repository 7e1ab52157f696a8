"""How fine a scan is looked at: by how densely it is seen where something is."""

from dataclasses import replace

import numpy as np

from workbench.perception.matching.maps import make_map
from workbench.perception.scene.scene_model import scene_model


def test_a_bin_much_larger_than_what_is_seen_does_not_blur_it(cell, scan, part):
    T_bin_scanner = cell.bin.T_world_bin.actInv(scan.T_world_scanner)
    at = scan.points @ T_bin_scanner.rotation.T + T_bin_scanner.translation
    seen = (np.abs(at[:, :2]) < 0.45 * cell.bin.size[:2]).all(axis=1)
    cut = replace(scan, points=scan.points[seen][::4], pixels=None, resolution=None)
    own = replace(cell, bin=replace(cell.bin, has_walls=False))
    wide = replace(own, bin=replace(own.bin, size=own.bin.size * (2.5, 2.5, 1.0)))

    def pitch(one):
        depth_map = make_map(cut, one.bin, scene_model(cut, one).bin, size=0.08, pitch=1e-4)
        assert depth_map is not None
        return depth_map.pitch

    assert pitch(wide) < 1.2 * pitch(own)
