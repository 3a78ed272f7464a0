"""Searches of this package."""
