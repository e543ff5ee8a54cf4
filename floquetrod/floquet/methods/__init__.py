"""Methods, one per file, none of which calls another: from an equation to a verdict, in files `system_` of a system."""
