"""The rod as a value: its parts, its formulas, its files and catalogue."""
