"""Models of the user: found, read, examined, repaired, made assets, and shown on a page (docs/your-models.md)."""
