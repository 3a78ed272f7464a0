"""Boxes of what a picture without depth shows."""
