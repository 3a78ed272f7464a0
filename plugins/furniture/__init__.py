"""Parametric models of household things, with doors and drawers: recipe + size -> asset folder (docs/assets.md)."""
