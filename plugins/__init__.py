"""Packages beside the core (docs/architecture.md); `diffusion` and `patchnet` are named as a user's own would be."""
