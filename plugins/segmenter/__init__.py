"""Cuts a picture with depth into things, floor and walls, by a network learnt in our rooms (docs/your-data.md)."""
