"""Pinhole camera, rasterised triangles, depth images.

Imports nothing of perception.
"""
