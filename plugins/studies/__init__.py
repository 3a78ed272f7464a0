"""Studies over many cells: what they found, and with which assets (docs/results)."""
