"""What the page says, in the language of who reads it.

All code speaks English: that is what is on record, in logs, in files, and what commands and the
HTTP interface answer.  Texts are put in another language where they leave for a browser, and
nowhere else (decision 39).

Imports the standard library alone.
"""
