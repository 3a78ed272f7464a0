"""Pictures, depth, cameras and masks as people have them."""
