"""The path of a scanner on an arm to its view: planned and proven."""
