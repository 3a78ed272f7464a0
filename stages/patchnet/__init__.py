"""The network of the patch encoder `patchnet`, its weights and its model card. Torch; no simulator."""
