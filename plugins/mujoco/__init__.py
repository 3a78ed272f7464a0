"""A second simulator for rollouts: doors and drawers in MuJoCo (docs/policies.md)."""
