"""The patch encoder `patchnet`: a small network trained on renders alone, its weights and its training."""
