"""The published study, DOI 10.1115/1.4031710, recomputed: its claims, its figures, a report."""
