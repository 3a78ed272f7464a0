"""Runs in operation: one workflow per folder, no job outlives it, fewer lines on the terminal, what a cluster lacks."""
