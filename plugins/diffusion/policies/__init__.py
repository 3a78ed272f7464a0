"""Policies of this package, by the name of their module."""
