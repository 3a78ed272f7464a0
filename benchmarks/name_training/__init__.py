"""Training data of the network of shapes: things of random rooms under masks with faults."""
