"""What happened and what may happen: commands, rules, and the one function that makes states.

Imports nothing of app.
"""
