"""How far two bodies are apart: searched by compiled code, or measured by Coal.

May import model and, beside it, bodies and bounds.
"""
