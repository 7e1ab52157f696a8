"""Universal Robots: URScript programs, RTDE client, simulated controller.

The extra `ur-rtde` brings the library of that name, which it needs.  Of other devices it imports
what streams share, `devices/streamed_way.py`.
"""
