"""Placing error, and what the grip removes from it.

Also: free places of pallets, seats of assemblies.  Imports `grasps` and `collision`.
"""
