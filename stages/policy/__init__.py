"""The policy network and its files: what `training` writes and `evaluation` reads. Torch, no simulator (paper B.3)."""
