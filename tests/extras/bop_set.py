"""A small data set in BOP's layout, of scans by our own simulated scanner."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from PIL import Image

from workbench.model.cell import Cell
from workbench.model.part import Part
from workbench.model.scan import Detection, Scan
from workbench.perception.simulation.synthesize import visible_shares
from workbench.perception.views.camera import Pinhole
from workbench.studies.bop.pose_errors import shape_of

DEPTH_SCALE = 0.1
"""Tenths of a millimetre: 16 bits reach 6.5 m."""


def write_bop_set(
    folder: Path,
    cell: Cell,
    numbers: Mapping[str, int],
    images: Sequence[tuple[Scan, Sequence[Detection]]],
) -> None:
    """All images as scene 1 of the split `test`; parts have the numbers given."""
    write_models(folder / "models", [(numbers[part.name], part) for part in cell.parts])
    camera = Pinhole.of_scanner(cell.scanner)
    cameras: dict[str, Any] = {}
    poses: dict[str, Any] = {}
    infos: dict[str, Any] = {}
    scene = folder / "test" / "000001"
    (scene / "depth").mkdir(parents=True)
    for k, (scan, truth) in enumerate(images):
        depth = np.zeros(camera.shape[0] * camera.shape[1])
        depth[scan.pixels] = scan.points[:, 2] * 1000 / DEPTH_SCALE
        image = Image.fromarray(np.rint(depth).reshape(camera.shape).astype(np.uint16))
        image.save(scene / "depth" / f"{k:06d}.png")
        cameras[str(k)] = {"cam_K": camera.matrix.ravel().tolist(), "depth_scale": DEPTH_SCALE}
        there = [scan.T_world_scanner.actInv(one.T_world_part) for one in truth]
        poses[str(k)] = [
            {
                "cam_R_m2c": T.rotation.ravel().tolist(),
                "cam_t_m2c": (T.translation * 1000).tolist(),
                "obj_id": numbers[one.part],
            }
            for one, T in zip(truth, there, strict=True)
        ]
        infos[str(k)] = [{"visib_fract": share} for share in visible_shares(cell, truth)]
    for name, content in (("camera", cameras), ("gt", poses), ("gt_info", infos)):
        (scene / f"scene_{name}.json").write_text(json.dumps(content))


def write_models(folder: Path, parts: Sequence[tuple[int, Part]]) -> None:
    """The meshes, with symmetries about the axis of each."""
    folder.mkdir(parents=True)
    infos: dict[str, Any] = {}
    for number, part in parts:
        mesh = trimesh.Trimesh(part.mesh.points * 1000, part.mesh.triangles, process=False)
        mesh.export(folder / f"obj_{number:06d}.ply")
        infos[str(number)] = {"diameter": shape_of(part).diameter * 1000}
        if part.symmetry.fold == 0:
            axis = {"axis": part.symmetry.axis.tolist(), "offset": [0, 0, 0]}
            infos[str(number)]["symmetries_continuous"] = [axis]
        elif not part.symmetry.is_none:
            infos[str(number)]["symmetries_discrete"] = [
                _in_mm(M).ravel().tolist() for M in part.symmetry.motions(1)[1:]
            ]
    (folder / "models_info.json").write_text(json.dumps(infos))


def _in_mm(M: Any) -> Any:
    return np.vstack([np.column_stack([M[:3, :3], M[:3, 3] * 1000]), M[3]])
