"""ABB's Externally Guided Motion, with a simulated controller.

`protobuf` is needed, an extra: `pip install workbench[egm]`.  Of other devices it imports what
streams share, `devices/streamed_way.py`.
"""
