"""Depth of a picture by a network."""
