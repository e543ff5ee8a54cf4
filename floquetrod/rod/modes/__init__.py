"""The modes of a rod under a kind of load: independent or coupled, behind one interface."""
