"""Equations of the modes at finite angles."""
