"""The published study, DOI 10.1115/1.4031710, made again from nothing: its claims, its figures, a report."""
