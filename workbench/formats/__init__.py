"""Files to values and back; millimetres and degrees of files stop here."""
