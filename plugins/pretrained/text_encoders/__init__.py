"""Text encoders of this package."""
