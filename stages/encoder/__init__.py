"""Training the patch encoder `patchnet` on pairs of pictures of procedural models (docs/matching.md)."""
