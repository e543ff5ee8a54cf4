"""The rod: what it is asked, and its large motion."""
