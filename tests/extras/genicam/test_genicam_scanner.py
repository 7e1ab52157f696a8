"""The driver `genicam` against the camera of aravis, a process of its own, over the loopback."""

import fcntl
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest
from genicam_cameras import (
    COLUMNS,
    DESCRIPTION,
    ROWS,
    camera,
    expected,
    is_right,
    needs_aravis,
    number,
    scanner,
    spread,
    taken,
)

from workbench.extras.genicam import library
from workbench.model.errors import JobCancelled, LinkError

pytestmark = needs_aravis
MANY = 10


@pytest.fixture(scope="module", autouse=True)
def alone_on_the_loopback():
    """GigE Vision has one port: cameras of another run of these tests are waited for."""
    with (Path(tempfile.gettempdir()) / "workbench-tests-genicam.lock").open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def test_every_scan_is_a_frame_of_its_own_point_by_point():
    with camera():
        scans = [taken(scanner()) for _ in range(MANY)]
    numbers = [number(scan) for scan in scans]
    assert numbers == sorted(set(numbers))
    assert all(is_right(scan) for scan in scans)
    assert scans[0].resolution == (COLUMNS, ROWS)


def test_pixels_of_the_invalid_count_are_no_points():
    # Each frame shifts the ramp by a pixel, and its period is 255.99 pixels.
    with camera():
        for _ in range(3):
            scan = taken(scanner(exposure_us=10_000, invalid=25600))
            held = np.isfinite(spread(scan)[..., 2])
            rows, columns = np.mgrid[:ROWS, :COLUMNS]
            ramp = 256 * (columns + rows + number(scan)) % 65535
            assert (held == (ramp != 25600)).all()


def test_the_exposure_of_the_cell_file_is_that_of_the_camera():
    with camera():
        assert is_right(taken(scanner(exposure_us=100_000)), brightness=2.0)
        assert is_right(taken(scanner(exposure_us=10_000)))


def test_a_cell_file_may_say_what_the_counts_mean():
    own = {"scale_mm": 0.02, "offset_mm": 500.0, "focal_px": 100.0, "center_u_px": 10.0}
    with camera():
        scan = taken(scanner(**own, center_v_px=20.0))
    z = (expected(number(scan))[..., 2] - 0.4) * 2 + 0.5
    rows, columns = np.mgrid[:ROWS, :COLUMNS]
    right = np.stack([z * (columns - 10) / 100, z * (rows - 20) / 100, z], axis=-1)
    np.testing.assert_allclose(spread(scan), right, rtol=1e-12)


@pytest.fixture(scope="module")
def pair():
    """What two cameras gave, in a network of their own with the addresses of both."""
    alone = ["unshare", "--map-root-user", "--net", "sh", "-c"]
    network = "ip link set lo up && ip addr add 127.0.0.2/8 dev lo"
    if shutil.which("ip") is None or subprocess.run([*alone, network], check=False).returncode:
        pytest.skip("no network of one's own can be made here (unshare, ip)")
    program = [sys.executable, str(DESCRIPTION.parents[1] / "genicam_pair.py")]
    paths = os.pathsep.join(path for path in sys.path if path)
    ran = subprocess.run(
        [*alone, f"{network} && exec {shlex.join(program)}"],
        env={**os.environ, "PYTHONPATH": paths},
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr
    return json.loads(ran.stdout)


def test_two_cameras_at_once_do_not_mix(pair):
    assert all(is_its_own for _, _, is_its_own in pair["both"])
    for brightness in (1.0, 2.0):
        numbers = [number for which, number, _ in pair["both"] if which == brightness]
        assert len(numbers) >= 5
        assert numbers == sorted(set(numbers))


def test_a_camera_is_found_by_its_serial_number(pair):
    assert pair["found"]
    unknown, either, other = pair["refusals"]
    assert re.search(r"GV03 answers \(found: GV0[12], GV0[12]\)", unknown)
    assert re.search(r"2 cameras answer \(.*\); choose one by serial", either)
    assert "has the serial number GV01, not GV02" in other


def test_a_frame_that_has_lost_packets_is_refused_and_never_a_scan():
    whole = refused = 0
    with camera(lost=80):
        while not (whole and refused):
            try:
                assert is_right(taken(scanner(patience=1.0)))
                whole += 1
            except LinkError as error:
                words = ("has lost packets", "did not arrive", "no image came", "not complete")
                assert any(word in str(error) for word in words), error
                refused += 1


def test_a_camera_that_goes_while_it_is_waited_for_is_told():
    # Nothing of its stream arrives, so it is waited for until it goes.
    with camera(lost=1000) as dead, pytest.raises(LinkError, match="the camera has gone"):
        taken(scanner(), report=lambda share, _: dead.kill() if share > 0.005 else None)


def test_a_camera_that_comes_back_is_used_again():
    with camera() as one:
        assert is_right(taken(scanner()))
        one.kill()
        with pytest.raises(LinkError, match="Can't connect"):
            taken(scanner())
        one.start()
        assert is_right(taken(scanner()))


def test_a_camera_that_sends_nothing_is_waited_for_as_long_as_the_cell_says():
    with camera(lost=1000):
        with pytest.raises(LinkError, match=r"no image came within 0\.3 s"):
            taken(scanner(patience=0.3))
        waits = iter([False, False, True])
        with pytest.raises(JobCancelled):
            taken(scanner(), cancelled=lambda: next(waits))


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("Scan3dFocalLength", "Other"), "has no Scan3dFocalLength; give focal_px"),
        (("Scan3dCoordinateScale", "Other"), "has no Scan3dCoordinateScale; give scale_mm"),
        (("<Value>80.5</Value>", "<Value>0</Value>"), "a scale and a focal length above zero"),
        (("<Value>2</Value></EnumEntry><Value>0<", "<Value>2</Value></EnumEntry><Value>2<"), "Pix"),
        (("C * 0.005", "C * 5"), r"is the scale of 10\.00 mm a count right"),
        (("W * H * 2", "W * H"), "have 6144 bytes, not 3072"),
        (("W * H * 2", "4000000000"), "4000000000 bytes is no depth map"),
        (("17825799", "17301505"), "its pixel format is 0x1080001"),
        (("Coord3D_C16", "Coord3D_ABC32f"), "not an entry"),
    ],
)
def test_a_camera_that_cannot_give_a_depth_map_is_told(tmp_path, change, says):
    text = DESCRIPTION.read_text(encoding="utf-8")
    assert change[0] in text
    other = tmp_path / "other.xml"
    other.write_text(text.replace(*change), encoding="utf-8")
    with camera(description=other), pytest.raises(LinkError, match=says):
        taken(scanner())


def test_without_the_library_it_is_said_what_installs_it(monkeypatch):
    monkeypatch.setattr(library, "LIBRARY", "libaravis-none.so")
    library.aravis.cache_clear()
    with pytest.raises(LinkError, match=r"libaravis-none\.so is not installed: apt-get install"):
        taken(scanner())
    library.aravis.cache_clear()
