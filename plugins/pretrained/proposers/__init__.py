"""Outlines by pretrained networks."""
