"""Controllers of Universal Robots: a plan as one URScript program, the foreign client, and a twin.

`ur-rtde` is needed, an extra: `pip install workbench[ur-rtde]`.  Of other devices it imports
what streams share, `devices/streamed_way.py`.
"""
