"""Planning is tried on a cell with two parts in its bin."""

from two_parts import cell, detections, result, world

__all__ = ["cell", "detections", "result", "world"]
