"""Ensembles of simulations: runs, stores, workers, statistics."""
