"""ABB's Externally Guided Motion: a plan streamed joint by joint over UDP, and a controller's twin.

`protobuf` is needed, an extra: `pip install workbench[egm]`.  Of other devices it imports what
streams share, `devices/streamed_way.py`.
"""
