"""Simulators of this package."""
