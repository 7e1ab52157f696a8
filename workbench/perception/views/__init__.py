"""What a camera would see of shapes: the pinhole, triangles, depth pictures.

Imports nothing of perception.
"""
