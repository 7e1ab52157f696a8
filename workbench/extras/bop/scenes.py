"""The images of a BOP data set: cameras, true poses and depths of its scenes, millimetres."""

from collections.abc import Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from workbench.extras.bop.models import LARGEST_FILE, whole_name
from workbench.formats.files.json_keys import parse_object
from workbench.formats.files.toml_keys import MISSING, Table, quote
from workbench.formats.files.whole_files import is_file, read_whole
from workbench.model.errors import FileError, InputError
from workbench.model.geometry import Floats, copy_pose, frozen, pose_from_matrix, put

TARGETS = ("test_targets_bop24.json", "test_targets_bop19.json")
"""The first of these that is there says which images of the split `test` count."""

IMAGE_ENDINGS = (".png", ".tif")
"""Of depth images."""

MOST_PIXELS = 50_000_000

OTHER_UNIT = 4.0
"""A depth image whose median is this many times as far as the true poses is in another unit."""

FARTHEST_PART = 20.0
"""[m] A part further away than this was given in other units."""


@dataclass(frozen=True, slots=True, eq=False)
class TruePose:
    """Where an object is in the camera's frame, and which share of its silhouette shows, 0..1."""

    object: int
    T_camera_object: pin.SE3
    visible: float

    def __post_init__(self) -> None:
        put(self, T_camera_object=copy_pose(self.T_camera_object))


@dataclass(frozen=True, slots=True, eq=False)
class BopImage:
    """One image: its camera matrix K (3, 3) [px], the file of depths in units of `unit` [m]."""

    scene: int
    number: int
    K: Floats
    depth: Path
    unit: float
    truth: tuple[TruePose, ...]

    def __post_init__(self) -> None:
        put(self, K=frozen(self.K))


def read_images(folder: Path, split: str, sensor: str = "") -> list[BopImage]:
    """All images of a split, scene by scene.

    Args:
        folder: the data set.
        split: the name of the folder with the scenes, `test` for instance.
        sensor: which one is meant where a scene has several, as in BOP-Industrial: the end of the
            names of its files.

    Raises:
        FileError: a file is missing or broken, or there are no scenes.
    """
    place = folder / split
    scenes = sorted(place.glob(f"*/scene_camera{_end(sensor)}.json"))
    if not scenes:
        raise FileError(
            place, f"holds no scenes: folders with a scene_camera{_end(sensor)}.json are expected"
        )
    wanted = _targets(folder) if split == "test" else None
    images = [image for path in scenes for image in _scene(path.parent, _end(sensor))]
    return [image for image in images if wanted is None or (image.scene, image.number) in wanted]


def read_depth(image: BopImage) -> Floats:
    """The depths (rows, columns) [m] along the optical axis, 0 where nothing was measured.

    Raises:
        FileError: it is no image of depths, or in another unit than the true poses.
    """
    with _open(image) as opened:
        path, depths = Path(opened.filename), _values(opened)
    if depths.ndim != 2:
        raise FileError(path, "is no image of depths: one channel is expected")
    depths = np.where(np.isfinite(depths) & (depths > 0), depths, 0.0) * image.unit
    if not depths.any():
        raise FileError(path, "holds no depth")
    seen = float(np.median(depths[depths > 0]))
    if image.truth:
        true = float(
            np.median([detection.T_camera_object.translation[2] for detection in image.truth])
        )
        if not true / OTHER_UNIT < seen < true * OTHER_UNIT:
            raise FileError(
                path,
                f"is {seen:.3g} m deep in the median, but its objects are {true:.3g} m away: "
                "depth times depth_scale has to be millimetres",
            )
    return depths


def depth_width(image: BopImage) -> int:
    """The width of an image [px].

    Raises:
        FileError: as `read_depth` has it.
    """
    with _open(image) as opened:
        return int(opened.width)


@contextmanager
def _open(image: BopImage) -> Generator[Any]:
    from PIL import Image

    path = next((p for p in map(image.depth.with_suffix, IMAGE_ENDINGS) if is_file(p)), None)
    if path is None:
        raise FileError(image.depth, "there is no such depth image, as PNG or TIFF")
    try:
        opened = Image.open(path)
    except Exception as error:  # the decoders raise whatever they like
        raise FileError(path, f"cannot be read as an image: {quote(str(error))}") from None
    with opened:
        if opened.width * opened.height > MOST_PIXELS:
            raise FileError(path, f"has more than {MOST_PIXELS} pixels")
        yield opened


def _values(opened: Any) -> Any:
    try:
        return np.asarray(opened, dtype=np.float64)
    except Exception as error:
        raise FileError(
            Path(opened.filename), f"cannot be read as an image: {quote(str(error))}"
        ) from None


def _end(sensor: str) -> str:
    return f"_{sensor}" if sensor else ""


def _targets(folder: Path) -> set[tuple[int, int]] | None:
    path = next((p for p in map(folder.joinpath, TARGETS) if is_file(p)), None)
    if path is None:
        return None
    # A list stands there, and our reader wants an object.
    content = b'{"targets":' + read_whole(path, LARGEST_FILE).removeprefix(b"\xef\xbb\xbf") + b"}"
    return {
        (target.whole("scene_id", low=0, high=10**9), target.whole("im_id", low=0, high=10**9))
        for target in Table(path, parse_object(path, content)).tables("targets", MISSING)
    }


def _scene(folder: Path, end: str) -> Iterator[BopImage]:
    scene = whole_name(folder, folder.name)
    cameras, poses = (_read(folder / f"scene_{name}{end}.json") for name in ("camera", "gt"))
    shares = folder / f"scene_gt_info{end}.json"
    visible = _read(shares) if is_file(shares) else None
    for key in cameras.names():
        number, camera = whole_name(cameras.path, key), cameras.table(key)
        truth = [_true_pose(table) for table in poses.tables(key, MISSING)]
        if visible is not None:
            infos = list(visible.tables(key, MISSING))
            if len(infos) != len(truth):
                raise visible.error(key, f"{len(truth)} entries are expected, as in scene_gt")
            truth = [
                TruePose(
                    detection.object,
                    detection.T_camera_object,
                    info.number("visib_fract", low=0, high=1),
                )
                for detection, info in zip(truth, infos, strict=True)
            ]
        yield BopImage(
            scene,
            number,
            _camera_matrix(camera),
            folder / f"depth{end}" / f"{number:06d}",
            camera.number("depth_scale", low=1e-9, high=1e6) / 1000,
            tuple(truth),
        )


def _read(path: Path) -> Table:
    return Table(path, parse_object(path, read_whole(path, LARGEST_FILE)))


def _camera_matrix(table: Table) -> Floats:
    K = table.numbers("cam_K", 9).reshape(3, 3)
    if not (K[0, 0] > 0 and K[1, 1] > 0 and np.array_equal(K[2], (0, 0, 1))):
        raise table.error("cam_K", "is no camera matrix: fx 0 cx 0 fy cy 0 0 1 is expected")
    return K


def _true_pose(table: Table) -> TruePose:
    R, t = table.numbers("cam_R_m2c", 9), table.numbers("cam_t_m2c", 3) / 1000
    try:
        T = pose_from_matrix(np.hstack([R.reshape(3, 3), t[:, None]]))
    except InputError as error:
        raise table.error("cam_R_m2c", str(error)) from None
    away = float(np.linalg.norm(t))
    if away > FARTHEST_PART:
        raise table.error("cam_t_m2c", f"is {away:.4g} m away; it has to be in millimetres")
    return TruePose(table.whole("obj_id", low=0, high=10**9), T, 1.0)
