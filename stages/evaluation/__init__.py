"""Rollouts of policies and scores of generated scenes: one row each, nothing is aggregated here (paper B.1, B.3)."""
