"""Scenes, demonstrations and policies in the formats of other tools (docs/data.md)."""
