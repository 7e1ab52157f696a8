"""What holds for all tests."""

from hypothesis import settings

# How long an example takes is a matter of the machine; what is slow shows in the benchmarks.
settings.register_profile("workbench", deadline=None)
settings.load_profile("workbench")
