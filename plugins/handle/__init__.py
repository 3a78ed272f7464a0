"""Policies that go by the handle: it is flagged in clouds, and in training fronts move under their handles."""
