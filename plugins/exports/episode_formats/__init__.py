"""Demonstrations in the formats of other people's tools: a module each, with `write(stores, out, library)`."""
