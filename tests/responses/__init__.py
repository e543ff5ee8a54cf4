"""Tests of steady motions under a force."""
