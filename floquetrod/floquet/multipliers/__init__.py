"""Verdicts on systems of equations: spectra with errors, what follows from them, and the names of resonances."""
