"""Any method's scenes against the truth of rooms that are not ours (docs/results/scorecard.md)."""
