"""Clouds in, poses out: pure functions."""

from typing import Any

import numba

# TBB comes last: where an old one is installed, numba warns of it at every start.
_config: Any = numba.config  # pyright: ignore[reportPrivateImportUsage]
_config.THREADING_LAYER_PRIORITY = ["omp", "tbb", "workqueue"]
