"""RGB-D frames of other people's cameras and data sets as input folders (docs/your-data.md)."""
