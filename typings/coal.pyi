"""Types for what the workbench uses of Coal, which comes without any."""

import numpy as np
from numpy.typing import NDArray

_Floats = NDArray[np.float64]

class CollisionGeometry: ...

class Box(CollisionGeometry):
    def __init__(self, size: _Floats, /) -> None: ...

class Sphere(CollisionGeometry):
    def __init__(self, radius: float, /) -> None: ...

class Cylinder(CollisionGeometry):
    def __init__(self, radius: float, length: float, /) -> None: ...

class Capsule(CollisionGeometry):
    def __init__(self, radius: float, length: float, /) -> None: ...

class Triangle:
    def __init__(self, first: int, second: int, third: int, /) -> None: ...

class StdVec_Vec3s:
    def append(self, point: _Floats, /) -> None: ...

class StdVec_Triangle:
    def append(self, triangle: Triangle, /) -> None: ...

class Convex(CollisionGeometry):
    def __init__(self, points: StdVec_Vec3s, triangles: StdVec_Triangle, /) -> None: ...

class BVHModelOBBRSS(CollisionGeometry):
    def __init__(self) -> None: ...
    def beginModel(self, triangles: int, points: int, /) -> int: ...
    def addTriangle(self, first: _Floats, second: _Floats, third: _Floats, /) -> int: ...
    def addSubModel(self, points: StdVec_Vec3s, triangles: StdVec_Triangle, /) -> int: ...
    def endModel(self) -> int: ...

class Transform3s:
    def __init__(self, rotation: _Floats, translation: _Floats, /) -> None: ...

class GJKInitialGuess:
    CachedGuess: GJKInitialGuess

class CollisionResult:
    def __init__(self) -> None: ...

class DistanceRequest:
    enable_nearest_points: bool
    gjk_initial_guess: GJKInitialGuess
    def __init__(self, enable_nearest_points: bool = ..., /) -> None: ...

class DistanceResult:
    min_distance: float
    def __init__(self) -> None: ...
    def clear(self) -> None: ...

def distance(
    first: CollisionGeometry,
    T_world_first: Transform3s,
    second: CollisionGeometry,
    T_world_second: Transform3s,
    request: DistanceRequest,
    result: DistanceResult,
    /,
) -> float: ...
