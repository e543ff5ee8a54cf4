"""Batches and families of systems."""
