"""The articulated model: URDF read and written, MJCF written, link frames, stretching, fronts. No simulator here."""
