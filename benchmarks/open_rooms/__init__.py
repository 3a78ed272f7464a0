"""Rooms furnished with other people's models, path-traced, reconstructed and scored: docs/results/open.md."""
