"""The articulated model: URDF read and written, link frames, closed box, stretching, fronts. No simulator here."""
