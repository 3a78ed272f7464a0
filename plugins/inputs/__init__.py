"""Inputs of the workflow: RGB-D frames, photographs drawn by hand or read by networks (docs/your-data.md)."""
