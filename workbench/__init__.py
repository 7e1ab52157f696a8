"""Workbench: plan, prove, approve and run robotic bin picks from a web page."""

import os
import platform

__version__ = "0.1.0"

# NumPy and its linear algebra choose their instructions by the make of processor, and these round
# differently: enough to find a part turned by a symmetry of its, or to take another way.  Here
# they take those that every x86-64 processor with AVX2 has, so that results are the same on all.
# Matrices are small here, so one thread and plain instructions cost no time.  Both libraries look
# at this once, when they are loaded; what somebody has set already stands.
if platform.machine() in ("x86_64", "AMD64"):
    os.environ.setdefault("OPENBLAS_CORETYPE", "Nehalem")
    os.environ.setdefault("NPY_DISABLE_CPU_FEATURES", "X86_V4 AVX512_ICL AVX512_SPR")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
