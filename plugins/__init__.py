"""Packages beside the workflow, each named in the config as a user's own would be (docs/extending.md)."""
