"""Simulators in which policies are rolled out, by name: a module with its environments as `Environment`."""
