"""Recordings made by the maker's library, of a camera that it makes up (its software device)."""

from pathlib import Path

import numpy as np

COLUMNS, ROWS = 64, 48
UNITS, FX, FY, U, V = 0.00025, 80.5, 81.5, 31.25, 23.75
SERIAL = "D400SOFT"
WAIT_MS = 60_000


def counts(number: int) -> np.ndarray:
    """The depth image (rows, columns) of a frame, counted from 1: a slope, another in each."""
    rows, columns = np.mgrid[:ROWS, :COLUMNS]
    image = 2000 + 100 * number + 3 * rows + 2 * columns
    image[::7, ::5] = 0
    return image.astype(np.uint16)


def points(number: int) -> np.ndarray:
    """Where the pixels (rows, columns, 3) [m] of a frame are, NaN where nothing was measured."""
    z = counts(number) * UNITS
    z[z == 0] = np.nan
    rows, columns = np.mgrid[:ROWS, :COLUMNS]
    return np.stack([z * (columns - U) / FX, z * (rows - V) / FY, z], axis=-1)


class Camera:
    """A camera that the library makes up: it sends the images that it is given."""

    def __init__(self, is_depth: bool = True, serial: str = SERIAL) -> None:
        import pyrealsense2 as rs

        intrinsics = rs.intrinsics()
        intrinsics.width, intrinsics.height = COLUMNS, ROWS
        intrinsics.fx, intrinsics.fy, intrinsics.ppx, intrinsics.ppy = FX, FY, U, V
        intrinsics.model, intrinsics.coeffs = rs.distortion.none, [0.0] * 5
        stream = rs.video_stream()
        stream.type = rs.stream.depth if is_depth else rs.stream.infrared
        stream.fmt = rs.format.z16 if is_depth else rs.format.y16
        stream.index, stream.uid, stream.fps, stream.bpp = 0, 0, 30, 2
        stream.width, stream.height, stream.intrinsics = COLUMNS, ROWS, intrinsics
        self.device = rs.software_device()
        self.device.register_info(rs.camera_info.name, "software")
        self.device.register_info(rs.camera_info.serial_number, serial)
        self.sensor = self.device.add_sensor("Depth")
        profile = self.sensor.add_video_stream(stream, True)
        self._profile = profile.as_video_stream_profile()
        self.sensor.add_read_only_option(rs.option.depth_units, UNITS)
        self._sdk = rs

    def send(self, number: int) -> None:
        """Send the image of that number."""
        frame = self._sdk.software_video_frame()
        frame.pixels = np.ascontiguousarray(counts(number))
        frame.stride, frame.bpp, frame.frame_number = 2 * COLUMNS, 2, number
        frame.timestamp = 33.0 * number
        frame.domain = self._sdk.timestamp_domain.system_time
        frame.profile = self._profile
        self.sensor.on_video_frame(frame)


def record(path: Path, frames: int, is_depth: bool = True) -> Path:
    """A recording of so many frames of depth, or of infrared."""
    import pyrealsense2 as rs

    camera = Camera(is_depth)
    recorder = rs.recorder(str(path), camera.device)
    recorded, queue = recorder.query_sensors()[0], rs.frame_queue(frames)
    recorded.open(recorded.get_stream_profiles()[0])
    recorded.start(queue)
    for number in range(1, frames + 1):
        camera.send(number)
        queue.wait_for_frame(WAIT_MS)
    recorded.stop()
    recorded.close()
    return path
