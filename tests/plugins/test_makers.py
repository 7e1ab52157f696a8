"""The page about scanners of three makers: its code runs against what stands for their libraries.

The libraries need the makers' own programs, which are not here: this shows that the code is whole,
not that a library is as its maker tells.
"""

import sys
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import MagicMock

import numpy as np
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.model.errors import LinkError
from workbench.plugins.progress import never, silent
from workbench.plugins.scanner import ScanRequest
from workbench.testing import check_scanner

HERE = Path(__file__).resolve().parent
PAGE = (HERE.parents[1] / "docs" / "plugins" / "makers_scanners.md").read_text()
FILES = sorted((HERE / "makers").glob("*.py"))
POINTS = np.random.default_rng(1).uniform((-100, -80, 700), (100, 80, 900), (6, 8, 3))
POINTS[2, 3] = np.nan


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_the_page_leads_to_what_was_run(file):
    assert f"[{file.name}](../../tests/plugins/makers/{file.name})" in PAGE


@pytest.fixture
def scanners(monkeypatch):
    """The three classes, and a stand-in for each library; its calls can be changed."""
    monkeypatch.syspath_prepend(str(HERE / "makers"))
    zivid, nxlib, mecheye = MagicMock(), MagicMock(), MagicMock()
    frame = SimpleNamespace(point_cloud=lambda: SimpleNamespace(copy_data={"xyz": POINTS}.get))
    zivid.Application().connect_camera().capture_3d.side_effect = lambda _: nullcontext(frame)
    camera = nxlib.Camera.from_serial().__enter__()
    camera.get_point_map.return_value = POINTS
    nxlib.NxLib().__exit__.return_value = nxlib.Camera.from_serial().__exit__.return_value = None
    mecheye.Camera().capture_3d.return_value.is_ok.return_value = True
    mecheye.Frame3D().get_untextured_point_cloud().data.return_value = POINTS
    monkeypatch.setitem(sys.modules, "zivid", zivid)
    monkeypatch.setitem(sys.modules, "nxlib", nxlib)
    monkeypatch.setitem(sys.modules, "mecheye", MagicMock())
    monkeypatch.setitem(sys.modules, "mecheye.area_scan_3d_camera", mecheye)
    import ensenso_scanner
    import mecheye_scanner
    import zivid_scanner

    yield {
        "zivid": (zivid_scanner.ZividScanner, zivid, {"settings": "/cell/bin.yml"}),
        "ensenso": (ensenso_scanner.EnsensoScanner, nxlib, {}),
        "mecheye": (mecheye_scanner.MechEyeScanner, mecheye, {}),
    }
    for file in FILES:
        sys.modules.pop(file.stem, None)


@pytest.mark.parametrize("name", ["zivid", "ensenso", "mecheye"])
def test_the_code_makes_a_scan_of_what_a_library_gives(scanners, name):
    kind, _, options = scanners[name]
    cell = read_cell("yumi")
    mount = replace(cell.scanner, source=name, address="1234", options=options)
    scan = check_scanner(kind, replace(cell, scanner=mount))
    measured = np.isfinite(POINTS[..., 2]).ravel()
    np.testing.assert_allclose(scan.points, POINTS.reshape(-1, 3)[measured] / 1000)
    assert scan.resolution == (8, 6) and len(scan.pixels) == 47


def test_what_a_library_refuses_is_told(scanners):
    cell = read_cell("yumi")
    for name, told in (("zivid", "no camera"), ("ensenso", "no camera"), ("mecheye", "no camera")):
        kind, library, options = scanners[name]
        if name == "zivid":
            library.Application().connect_camera.side_effect = RuntimeError(told)
        elif name == "ensenso":
            library.Camera.from_serial.side_effect = KeyError(told)
        else:
            status = SimpleNamespace(is_ok=lambda: False, error_description="no camera")
            library.Camera().connect.return_value = status
        given = options and kind.Options(**options)
        scanner = kind(replace(cell, scanner=replace(cell.scanner, address="1234")), given)
        with pytest.raises(LinkError, match=told):
            scanner.scan(ScanRequest(), silent, never)
