"""Sessions as MCAP files, for Foxglove and ROS.

`mcap` is needed, an extra: `pip install workbench[mcap]`.
"""
