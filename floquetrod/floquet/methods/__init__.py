"""Methods, one to a file: from an equation to a verdict, in files ``system_`` from a system; none calls another."""
