"""Captions of what is in a picture, by a language model."""
