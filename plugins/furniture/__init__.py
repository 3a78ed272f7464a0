"""Parametric models of household things, with doors and drawers: recipe + size -> asset folder (docs/assets.md)."""

from plugins.furniture.folder import build, generate

__all__ = ["build", "generate"]
