"""Policies that go by the handle: it is flagged in clouds, and in training fronts move under it (docs/policies.md)."""
