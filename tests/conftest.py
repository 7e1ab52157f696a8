"""What holds for all tests."""

from hypothesis import HealthCheck, settings

# How long an example takes is a matter of the machine; what is slow shows in the benchmarks.
settings.register_profile("workbench", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("workbench")
