"""Sessions as MCAP files, for Foxglove and ROS.

The extra `mcap` brings the library of that name, which it needs.
"""
