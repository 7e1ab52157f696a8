"""The link to any robot program: it is the client, and asks by lines of text what comes next.

`docs/pick_server.md` has every byte.
"""
