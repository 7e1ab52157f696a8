"""How sure it is where a part comes to lie: what is not known of it, and what the grip takes out.

And which places of pallets are open to it.  Imports `grasps` and `collision`.
"""
