"""Other makes of processor, as far as libraries can be told to behave as if there were one.

Each leaves out instructions that the processor at hand has, in one library or in all.  What
cannot be told is left: MuJoCo is compiled for one set of instructions, and the Embree inside
Open3D asks the processor itself.
"""

OLD_SINES = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX,-FMA4"}

OTHERS = {
    "wide linear algebra": {"OPENBLAS_CORETYPE": "Haswell", "OPENBLAS_NUM_THREADS": "2"},
    "sines of older processors": OLD_SINES,
    "plain instructions everywhere": {
        "OPENBLAS_CORETYPE": "Prescott",
        "NPY_DISABLE_CPU_FEATURES": "X86_V3",
        **OLD_SINES,
    },
}
