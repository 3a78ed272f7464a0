"""What the network of shapes learns from: things of random rooms under masks with faults."""
