"""Outlines: what proposes them, and the choice among them."""
