"""Robustness variants of the rooms of Table 2: their table, and what matching does without (docs/scenes.md)."""
