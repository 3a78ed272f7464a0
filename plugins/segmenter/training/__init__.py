"""Training the segmenter on random rooms of procedural models, seen by rays: `python -m plugins.segmenter train`."""
