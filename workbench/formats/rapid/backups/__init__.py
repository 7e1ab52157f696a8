"""Programs as they lie on a disk: files, folders of a backup, its configuration.

This folder imports the language (`formats/rapid`) and `formats/files`.
"""
