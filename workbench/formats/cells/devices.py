"""A cell file's scanner, localizer and controller: found by name, with keys of their own."""

from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from workbench.formats.cells.calibrations import read_record
from workbench.formats.clouds.scans import KNOWN_AXES
from workbench.formats.files.toml_keys import Table
from workbench.formats.files.units import UNITS
from workbench.formats.meshes.solids import read_pose
from workbench.formats.robots.arm_scanners import POSE
from workbench.model.cell import IN_WORLD, Z_FORWARD, Controller, ScannerMount
from workbench.model.errors import FileError, InputError
from workbench.model.robot import ArmScanner
from workbench.model.scan import LocalizerChoice
from workbench.plugins.found import load, names
from workbench.plugins.options import Options, options_of
from workbench.plugins.robot_link import controller_by, link_named, usual_link


def read_scanner(table: Table, on_arm: ArmScanner | None = None) -> ScannerMount:
    """The table `[scanner]`, whose key `on_arm` has been read, if it is there."""
    columns, rows = table.wholes("resolution", 2, [640, 480], low=16, high=4096)
    mount = ScannerMount(
        T_world_scanner=read_pose(table),
        resolution=(columns, rows),
        field_of_view=float(np.deg2rad(table.number("field_of_view_deg", low=1, high=150))),
        depth_noise=table.number("depth_noise_mm", 0.3, low=0, high=20) / 1000,
        near=table.number("near_mm", 300, low=1, high=20_000) / 1000,
        far=table.number("far_mm", 1500, low=1, high=20_000) / 1000,
        source=table.text("source", "simulated", among=names("workbench.scanners")),
        address=_address(table),
        unit=table.text("unit", "m", among=tuple(UNITS)),
        patience=table.number("patience_s", 60, low=0.1, high=3600),
        calibration=read_record(table.table("calibration")) if table.has("calibration") else None,
        calibration_days=table.number("calibration_days", 90, low=0.1, high=3650),
        cloud_axes=table.text("cloud_axes", Z_FORWARD, among=KNOWN_AXES),
        while_moving=table.flag("while_moving", False),
        on_arm=on_arm,
    )
    with refused_at(table, "source"):
        options = read_options(table, load("workbench.scanners", mount.source).Options)
        mount = replace(mount, options=options)
    table.finish()
    if mount.on_arm is not None:
        _check_on_arm(table, mount)
    if mount.source in ("folder", "http", "merged") and not mount.address:
        raise table.error("address", f"source {mount.source!r} needs one")
    if mount.source == "http" and not mount.address.startswith(("http://", "https://")):
        raise table.error("address", f"{mount.address!r} does not begin with http:// or https://")
    if mount.source == "http" and "@" in mount.address.split("/")[2]:
        # Not shown: it would go on into logs.
        raise table.error("address", "holds a login; `login` and so on in [scanner.options] say it")
    if mount.source == "merged" and mount.calibration is not None:
        raise table.error("calibration", "a merged scanner has none: each of its views has its own")
    if mount.cloud_axes == IN_WORLD and mount.calibration is not None:
        raise table.error("calibration", "points in the cell's frame need none (cloud_axes)")
    if mount.source == "merged" and mount.while_moving:
        raise table.error("while_moving", "a merged scanner sees from several places: it waits")
    if not mount.near < mount.far:
        raise table.error("near_mm", "must be less than far_mm")
    return mount


def _check_on_arm(table: Table, mount: ScannerMount) -> None:
    """Refuse what only a scanner that stands can be."""
    for key in POSE:
        if table.has(key):
            raise table.error(
                key, "the scanner stands here and hangs on an arm, too: on_arm says where it is"
            )
    if mount.source == "merged":
        raise table.error("source", "a merged scanner stands; it cannot hang on an arm")
    if mount.while_moving:
        raise table.error("while_moving", "a scanner on an arm waits until its arm stands still")


def _address(table: Table) -> str:
    """As it is; only a folder is one beside the cell file, so that has an absolute path."""
    address = table.text("address", "", empty=True)
    is_folder = table.text("source", "simulated") in ("folder", "merged")
    if not address or not is_folder or "://" in address:
        return address
    return str((table.path.parent / address).resolve())


def read_controller(table: Table) -> Controller:
    """The table `[controller]`."""
    name = table.text("protocol", usual_link(), among=names("workbench.robot_links"))
    port = table.whole("port", 1025, low=1, high=65535)
    host = table.text("host", "127.0.0.1")
    state_port = table.whole("state_port", min(port + 1, 65535), low=1, high=65535)
    with refused_at(table, "protocol"):
        kind = link_named(name).Options
        options = read_options(table, kind)
        controller = controller_by(name, host, port, state_port, options)
    table.finish()
    return controller


def read_localizer(table: Table) -> LocalizerChoice:
    """The table `[localizer]`."""
    name = table.text("name", among=names("workbench.localizers"))
    with refused_at(table, "name"):
        choice = LocalizerChoice(
            name, read_options(table, load("workbench.localizers", name).Options)
        )
    table.finish()
    return choice


def read_options(table: Table, kind: type) -> Options:
    """The keys of its own that a plug-in has, as a table `options`; see `plugins.options`."""
    given = table.table("options").plain() if table.has("options") else {}
    try:
        options_of(kind, given)
    except InputError as error:
        raise table.error("options", str(error)) from None
    return given


@contextmanager
def refused_at(table: Table, key: str) -> Generator[None]:
    """What a plug-in refuses is reported with the place in the file."""
    try:
        yield
    except FileError:
        raise
    except InputError as error:
        raise table.error(key, str(error)) from None
