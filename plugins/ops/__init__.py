"""Runs in operation: one workflow per folder, no job outlives it, a short log, clusters (docs/running.md)."""
