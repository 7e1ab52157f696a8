"""RAPID, the language of ABB's controllers, executed: the shipped modules run as they are.

Imports nothing of the other devices.  `lark` is needed, an extra: `pip install workbench[rapid]`.
"""
