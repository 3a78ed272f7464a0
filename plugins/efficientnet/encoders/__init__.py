"""The patch encoder `efficientnet`."""
