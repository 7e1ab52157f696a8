"""ABB's Externally Guided Motion, with a simulated controller.

The extra `egm` brings `protobuf`, which it needs.  Of other devices it imports what
streams share, `devices/streamed_way.py`.
"""
