"""Universal Robots: URScript programs, RTDE client, simulated controller.

`ur-rtde` is needed, an extra: `pip install workbench[ur-rtde]`.  Of other devices it imports
what streams share, `devices/streamed_way.py`.
"""
