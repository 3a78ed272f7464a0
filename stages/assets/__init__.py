"""Stage `assets`: the library of models and their snapshots (paper A.1)."""
