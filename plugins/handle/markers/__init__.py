"""What marks points of clouds."""
