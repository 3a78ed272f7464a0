"""Beside Table 3: success on unseen assets, the paper's claims, trainings that failed (docs/tables.md)."""
