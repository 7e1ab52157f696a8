"""What the page says, in the language of who reads it.

Messages (`workbench.model.messages`) are rendered by their ids.  Texts that have no id yet are
English everywhere in the code, and put in another language where they leave for a browser
(decision 53).

Imports model.
"""
