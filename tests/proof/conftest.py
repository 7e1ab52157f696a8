"""Proofs are tried on a plan for two parts, which is bent."""

from two_parts import cell, detections, result, world

__all__ = ["cell", "detections", "result", "world"]
