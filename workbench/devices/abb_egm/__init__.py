"""ABB's Externally Guided Motion: a plan streamed joint by joint over UDP, and a controller's twin.

`protobuf` is needed, an extra: `pip install workbench[egm]`.  Imports nothing of other devices.
"""
