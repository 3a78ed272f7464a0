"""Tasks of this package."""
