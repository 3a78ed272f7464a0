"""What applies corrections of this package."""
