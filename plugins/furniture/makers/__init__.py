"""Makers of this package."""
