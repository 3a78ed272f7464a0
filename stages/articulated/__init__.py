"""The articulated model: URDF read and written, link frames, closed box, stretching, panels. No simulator here."""
