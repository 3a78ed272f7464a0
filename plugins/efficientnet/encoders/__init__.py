"""What the config finds here: the patch encoder `efficientnet`."""
