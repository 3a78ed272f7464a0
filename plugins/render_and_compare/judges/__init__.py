"""Judges of this package."""
