"""Our end of the link to an ABB controller: messages, programs, conversations.

Imports nothing of the other devices.
"""
