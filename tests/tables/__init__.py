"""Tables of instruments in text files: their heads."""
