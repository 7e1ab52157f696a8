"""Clouds in, poses out: pure functions."""

import numba

# TBB comes last: where an old one is installed, numba warns of it at every start.
numba.config.THREADING_LAYER_PRIORITY = ["omp", "tbb", "workqueue"]
