"""Types for what the workbench uses of EAIK's compiled module, which comes without any."""

import numpy as np
from numpy.typing import NDArray

_Floats = NDArray[np.float64]

class Solutions:
    Q: list[_Floats]

class Robot:
    def __init__(
        self,
        axes: _Floats,
        offsets: _Floats,
        R_last_tcp: _Floats,
        fixed: list[tuple[int, float]],
        is_double: bool,
        /,
    ) -> None: ...
    def has_known_decomposition(self) -> bool: ...
    def calculate_IK(self, T: _Floats, /) -> Solutions: ...
