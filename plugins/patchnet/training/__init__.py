"""Training `patchnet` on pairs of pictures of procedural models: `python -m plugins.patchnet`."""
