"""Parametric models of household things, with doors and drawers: recipe + size -> asset folder. No simulator here."""

from plugins.furniture.folder import build, generate

__all__ = ["build", "generate"]
