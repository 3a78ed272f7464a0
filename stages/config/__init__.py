"""Typed models of config.yaml; they generate the file itself, its schema and its reference."""
