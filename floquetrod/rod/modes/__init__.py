"""What the modes of a rod are under a kind of load: independent or coupled, behind one interface."""
