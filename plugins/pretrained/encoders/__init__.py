"""Patch encoders of this package."""
