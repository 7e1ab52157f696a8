"""Cameras of aravis as processes of their own on the loopback, and what their pictures hold."""

import shutil
import socket
import struct
import subprocess
import time
from collections.abc import Generator
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from waiting import PATIENCE

from workbench.extras.genicam.library import is_installed
from workbench.extras.genicam.scanner import GenicamOptions, GenicamScanner
from workbench.formats.cells.reading import read_cell
from workbench.model.cell import Cell, ScannerMount
from workbench.model.geometry import Floats
from workbench.model.scan import Scan
from workbench.plugins.scanner import ScanRequest

PROGRAM = "arv-fake-gv-camera-0.8"
DESCRIPTION = Path(__file__).with_name("genicam") / "depth_camera.xml"
needs_aravis = pytest.mark.skipif(
    shutil.which(PROGRAM) is None or not is_installed(),
    reason="libaravis-0.8-0 and aravis-tools are not installed",
)

COLUMNS, ROWS = 64, 48
SCALE, OFFSET, FOCAL, CENTER = 1e-5, 0.4, 80.5, (31.25, 23.75)
"""As the description has them, in metres and pixels."""

INVALID = 256


class FakeCamera:
    """The process of a camera, which can be killed and started again."""

    def __init__(self, address: str, serial: str, *, lost: int = 0, description=DESCRIPTION):
        self.address = address
        self._command = [PROGRAM, "-i", address, "-s", serial, "-r", str(lost)]
        self._command += ["-g", str(description)]
        self.start()

    def start(self) -> None:
        """Begin, with a small picture."""
        # Standard output of the tests' own programs is theirs.
        self.process = subprocess.Popen(
            self._command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL
        )
        self.write(0x100, COLUMNS)
        self.write(0x104, ROWS)

    def kill(self) -> None:
        """End at once, without a word to anybody."""
        self.process.kill()
        self.process.wait()

    def write(self, register: int, value: int) -> None:
        """Write a register by GigE Vision's WRITEREG_CMD, as soon as it answers."""
        ask = struct.pack(">BBHHHII", 0x42, 1, 0x0082, 8, 1, register, value)
        until = time.monotonic() + PATIENCE
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as wire:
            wire.settimeout(0.1)
            wire.connect((self.address, 3956))
            while time.monotonic() < until and self.process.poll() is None:
                with suppress(OSError):
                    wire.send(ask)
                    if wire.recv(64)[2:4] == b"\x00\x83":
                        return
                time.sleep(0.02)
        raise AssertionError(f"no camera answers at {self.address}")


@contextmanager
def camera(address: str = "127.0.0.1", serial: str = "GV01", **options) -> Generator[FakeCamera]:
    """A camera that ends with the block."""
    made = FakeCamera(address, serial, **options)
    try:
        yield made
    finally:
        made.kill()


def scanner(address: str = "127.0.0.1", patience: float = 60.0, **options) -> GenicamScanner:
    """The driver in a cell that has its scanner there."""
    mount = ScannerMount(pin.SE3.Identity(), address=address, patience=patience)
    return GenicamScanner(replace(_cell(), scanner=mount), GenicamOptions(**options))


@cache
def _cell() -> Cell:
    return read_cell("yumi")


def taken(by: GenicamScanner, report=lambda *_: None, cancelled=lambda: False) -> Scan:
    """A scan."""
    return by.scan(ScanRequest(), report, cancelled)


def number(scan: Scan) -> int:
    """Of the frame."""
    return int(scan.source.rpartition(" ")[2])


def counts(frame: int, brightness: float = 1.0) -> np.ndarray:
    """What the camera draws in Mono16: a ramp that each frame shifts, times its exposure.

    By `arv_fake_camera_diagonal_ramp` of aravis 0.8, arvfakecamera.c.
    """
    rows, columns = np.mgrid[:ROWS, :COLUMNS]
    ramp = 256 * (columns + rows + frame) % 65535
    return np.clip(ramp * brightness, 0, 65535).astype(np.uint16)


def expected(frame: int, brightness: float = 1.0) -> Floats:
    """The cloud (ROWS, COLUMNS, 3) [m] of a frame, a pixel at a time."""
    cloud = np.full((ROWS, COLUMNS, 3), np.nan)
    for (row, column), count in np.ndenumerate(counts(frame, brightness)):
        if count != INVALID:
            z = OFFSET + SCALE * float(count)
            x, y = ((at - middle) / FOCAL for at, middle in zip((column, row), CENTER, strict=True))
            cloud[row, column] = (x * z, y * z, z)
    return cloud


def spread(scan: Scan) -> Floats:
    """The points of a scan at their pixels (ROWS, COLUMNS, 3), NaN where there are none."""
    cloud = np.full((ROWS * COLUMNS, 3), np.nan)
    cloud[scan.pixels] = scan.points
    return cloud.reshape(ROWS, COLUMNS, 3)


def is_right(scan: Scan, brightness: float = 1.0) -> bool:
    """Whether a scan is its frame, point by point."""
    right = expected(number(scan), brightness)
    return bool(np.allclose(spread(scan), right, rtol=1e-12, atol=0, equal_nan=True))
