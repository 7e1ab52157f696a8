"""A module of jobs that cannot be imported."""

raise RuntimeError("a library is missing")
