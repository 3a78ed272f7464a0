"""Mesh files that assets of ours are not: a module per suffix, with its `READER`."""
