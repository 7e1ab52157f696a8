"""Files as large as the page takes: surfaces of very many triangles, clouds of very many points."""

import json
import struct
from collections.abc import Callable, Mapping

import numpy as np

from workbench.formats.files.units import UNITS
from workbench.model.cell import Cell
from workbench.model.geometry import Floats, Ints, transform

TRIANGLES = 950_000
"""Of a CAD file; 1,000,000 are taken."""

RADIUS_MM, THICKNESS_MM = 30.0, 12.0
"""Of a ring."""


def ring(triangles: int) -> tuple[Floats, Ints]:
    """A closed surface on z = 0: corners (n, 3) [mm], about as many triangles (m, 3) as asked."""
    around = int(np.sqrt(triangles / 2))
    along = triangles // (2 * around)
    u, v = np.meshgrid(
        np.linspace(0, 2 * np.pi, along, endpoint=False),
        np.linspace(0, 2 * np.pi, around, endpoint=False),
        indexing="ij",
    )
    out = RADIUS_MM + THICKNESS_MM * np.cos(v)
    points = np.stack([out * np.cos(u), out * np.sin(u), THICKNESS_MM * (1 + np.sin(v))], axis=-1)
    i, j = np.meshgrid(np.arange(along), np.arange(around), indexing="ij")
    here, beside = i * around + j, i * around + (j + 1) % around
    ahead, across = (i + 1) % along * around + j, (i + 1) % along * around + (j + 1) % around
    faces = np.stack([here, ahead, across, here, across, beside], axis=-1)
    return points.reshape(-1, 3), faces.reshape(-1, 3).astype(np.int32)


def stl(points: Floats, triangles: Ints) -> bytes:
    """A binary STL file of corners (n, 3) [mm] and triangles (m, 3)."""
    rows = np.zeros(
        len(triangles), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")]
    )
    rows["corners"] = points[triangles]
    return bytes(80) + struct.pack("<I", len(rows)) + rows.tobytes()


def obj(points: Floats, triangles: Ints) -> bytes:
    """An OBJ file of corners (n, 3) [mm] and triangles (m, 3)."""
    lines = [f"v {x:.4f} {y:.4f} {z:.4f}" for x, y, z in points.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (triangles + 1).tolist()]
    return "\n".join(lines).encode()


def ply(points: Floats, triangles: Ints) -> bytes:
    """A binary PLY file of corners (n, 3) [mm] and triangles (m, 3)."""
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(points)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = np.zeros(len(triangles), [("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, triangles
    return header.encode() + points.astype("<f4").tobytes() + faces.tobytes()


def glb(points: Floats, triangles: Ints) -> bytes:
    """A GLB file, in metres, of corners (n, 3) [mm] and triangles (m, 3)."""
    corners = (points / 1000).astype("<f4")
    content = corners.tobytes() + triangles.astype("<u4").tobytes()
    said = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(content)}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": corners.nbytes},
            {"buffer": 0, "byteOffset": corners.nbytes, "byteLength": triangles.size * 4},
        ],
        "accessors": [
            {
                "bufferView": 0, "componentType": 5126, "count": len(corners), "type": "VEC3",
                "min": corners.min(axis=0).tolist(), "max": corners.max(axis=0).tolist(),
            },
            {"bufferView": 1, "componentType": 5125, "count": triangles.size, "type": "SCALAR"},
        ],
    }  # fmt: skip
    text = json.dumps(said).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    chunks += struct.pack("<II", len(content), 0x004E4942) + content
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


CAD: Mapping[str, Callable[[Floats, Ints], bytes]] = {
    ".stl": stl, ".obj": obj, ".ply": ply, ".glb": glb,
}  # fmt: skip
"""By the ending of the file."""


def cad_file(kind: str, triangles: int = TRIANGLES) -> bytes:
    """A CAD file of one closed ring; `kind` is one of `CAD`."""
    return CAD[kind](*ring(triangles))


def cloud(cell: Cell, count: int) -> bytes:
    """A scan of the cell's bin with this many points, as a binary PLY file of its scanner's."""
    length, width, height = cell.bin.size
    random = np.random.default_rng(0)
    around = [random.uniform(-side / 2, side / 2, count) for side in (length, width)]
    up = 0.3 * height * np.sin(40 * around[0]) ** 2 + random.normal(0, 4e-4, count)
    T = cell.scanner.T_world_scanner.inverse() * cell.bin.T_world_bin
    points = transform(T, np.column_stack([*around, up]))
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {count}\n"
        "property float x\nproperty float y\nproperty float z\nend_header\n"
    )
    return header.encode() + (points / UNITS[cell.scanner.unit]).astype("<f4").tobytes()
