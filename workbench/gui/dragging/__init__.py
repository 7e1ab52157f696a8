"""What a person drags with a gizmo: how far it is believed, and how candidates would be judged.

Imports `shared` and `scene`.
"""
