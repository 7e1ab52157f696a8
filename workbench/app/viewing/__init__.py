"""The way of a scanner on an arm to its view: planned and proven."""
