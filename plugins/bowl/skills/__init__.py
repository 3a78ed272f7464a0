"""Skills of this package."""
