"""What a scan says beside the parts: the bin itself, and what nobody modelled.

Imports `views`.
"""
