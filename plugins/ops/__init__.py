"""Runs in operation: one workflow per folder, no job outlives it, clusters (docs/running.md)."""
