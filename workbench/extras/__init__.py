"""The shelf of extras: what only some users need, one folder a capability.

May import everything; nothing imports an extra, and no extra another one.  The core starts them by
name: see `plugins.extras`.
"""
