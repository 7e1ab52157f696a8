"""Controllers of Universal Robots: a plan as one URScript program, the foreign client, and a twin.

`ur-rtde` is needed, an extra: `pip install workbench[ur-rtde]`.  Imports nothing of other devices.
"""
