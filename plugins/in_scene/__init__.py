"""Demonstrations inside generated scenes, with furniture in the way and behind (the paper's Figure 7)."""
