"""Scenes of other formats as things of a room: a module per format, with `read`."""
