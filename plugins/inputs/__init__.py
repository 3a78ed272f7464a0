"""What brings pictures in: RGB-D frames, photographs drawn by hand or read by networks (docs/your-data.md)."""
