"""The articulated model: URDF read and written, link frames, stretching, fronts. No simulator here."""
