"""Multipliers of systems of equations: maps over a period, spectra with errors, verdicts, and names of resonances."""
