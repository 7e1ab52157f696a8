from typing import Any

from numpy.typing import ArrayLike, NDArray

class Tensor:
    def __init__(self, values: ArrayLike, /) -> None: ...
    def numpy(self) -> NDArray[Any]: ...
