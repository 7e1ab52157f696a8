"""Scans from a folder: complete ones only, in time, and a word when not."""

import functools
import threading

import numpy as np
import pinocchio as pin
import pytest
from scanner_calls import SCAN, T, made, taken

from workbench.devices.scanners.folder import FolderScanner
from workbench.formats.clouds.scans import write_cloud
from workbench.model.errors import FileError, JobCancelled, LinkError
from workbench.model.scan import Scan


def test_the_next_file_is_the_scan(tmp_path):
    write_cloud(tmp_path / "old.ply", SCAN)
    newer = Scan(SCAN.points + 0.01, T, "newer")
    scanner = made(FolderScanner, tmp_path)
    assert taken(scanner, lambda: write_cloud(tmp_path / "new.ply", newer)).digest == newer.digest


def test_a_file_is_read_when_it_is_complete(tmp_path):
    write_cloud(tmp_path / "whole.bin", SCAN)
    content = (tmp_path / "whole.bin").read_bytes()

    def more(start: int) -> None:
        with (tmp_path / "scan.ply").open("ab") as file:
            file.write(content[start : start + 2000])

    pieces = [functools.partial(more, start) for start in range(0, len(content), 2000)]
    assert len(pieces) > 5
    assert taken(made(FolderScanner, tmp_path), *pieces).digest == SCAN.digest


def test_a_file_that_was_being_written_when_the_scan_was_asked_for_is_not_taken(tmp_path):
    write_cloud(tmp_path / "whole.bin", SCAN)
    content = (tmp_path / "whole.bin").read_bytes()
    (tmp_path / "scan.ply").write_bytes(content[:2000])
    newer = Scan(SCAN.points + 0.01, T, "newer")

    def rest() -> None:
        with (tmp_path / "scan.ply").open("ab") as file:
            file.write(content[2000:])

    # Each report is a tenth of a second after the one before, at least.
    then = [rest, *[lambda: None] * 10, lambda: write_cloud(tmp_path / "scan.ply", newer)]
    assert taken(made(FolderScanner, tmp_path), *then).digest == newer.digest


def test_a_file_that_is_renamed_into_place_counts(tmp_path):
    write_cloud(tmp_path / "scan.part", SCAN)
    scanner = made(FolderScanner, tmp_path)
    found = taken(scanner, lambda: (tmp_path / "scan.part").rename(tmp_path / "scan.ply"))
    assert found.digest == SCAN.digest


def test_millimetres_are_millimetres(tmp_path):
    in_mm = Scan(SCAN.points * 1000, T, "mm")
    scanner = made(FolderScanner, tmp_path, unit="mm")
    found = taken(scanner, lambda: write_cloud(tmp_path / "scan.ply", in_mm))
    np.testing.assert_allclose(found.points, SCAN.points, rtol=1e-12)


def test_no_file_no_folder_and_a_broken_file_are_told(tmp_path):
    write_cloud(tmp_path / "old.ply", SCAN)
    with pytest.raises(LinkError, match=r"no new PLY or PCD file came .* within 0.4 s"):
        taken(made(FolderScanner, tmp_path, patience=0.4))
    with pytest.raises(LinkError, match="there is no folder"):
        taken(made(FolderScanner, tmp_path / "nowhere"))
    scanner = made(FolderScanner, tmp_path)
    with pytest.raises(FileError, match="neither a PLY nor a PCD"):
        taken(scanner, lambda: (tmp_path / "scan.pcd").write_bytes(b"not a cloud"))


def test_a_folder_that_goes_while_a_scan_is_awaited_is_told(tmp_path):
    folder = tmp_path / "scans"
    folder.mkdir()
    with pytest.raises(LinkError, match="scans: No such file"):
        taken(made(FolderScanner, folder), folder.rmdir)


def test_waiting_can_be_cancelled(tmp_path):
    over = threading.Event()
    with pytest.raises(JobCancelled):
        taken(made(FolderScanner, tmp_path), over.set, cancelled=over.is_set)


def test_the_scan_stands_where_the_scanner_does(tmp_path):
    scanner = made(FolderScanner, tmp_path)
    found = taken(scanner, lambda: write_cloud(tmp_path / "scan.ply", SCAN))
    assert isinstance(found.T_world_scanner, pin.SE3)
    assert found.T_world_scanner.isApprox(T)
