"""Packages beside the core (docs/architecture.md); `diffusion` is named as a user's own would be."""
