"""Sessions as MCAP files, for Foxglove and tools of ROS: schemas, messages, the file.

`mcap` is needed, an extra: `pip install workbench[mcap]`.
"""
