"""Placing error, and what the grip removes from it.

Also: free places of pallets.  Imports `grasps` and `collision`.
"""
