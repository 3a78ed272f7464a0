"""Studies over many cells: what they found, how training sets compare, which models to train on (docs/results)."""
