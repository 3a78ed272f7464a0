"""Robustness variants of the rooms of Table 2 (`experiment.protocols`): their table, and what matching does without."""
