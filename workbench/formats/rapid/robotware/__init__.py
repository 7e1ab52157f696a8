"""What RobotWare knows, by signature: instructions, functions, types and data, as tables of text.

The tables say how they are written, in `motion.txt`, `types.txt` and `data.txt`.  They were written
after ABB's "Technical reference manual: RAPID instructions, functions and data types" (3HAC050917)
and the application manuals of the options.  This folder imports the values of the language alone.
"""
