"""Eight furnished rooms with a known truth, and their photographs (paper B.1, Table 2; docs/scenes.md)."""
