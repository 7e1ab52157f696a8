"""RAPID, the language of ABB's controllers: modules read, checked and made callables.

`lark` is needed, an extra: `pip install workbench[rapid]`.
"""
