"""Cuts a picture with depth into things, floor and walls, by a network that learnt from rooms of our own models."""
