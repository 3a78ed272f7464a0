"""The scripted skill on the test assets of the policies, as an upper reference beside them (docs/tables.md)."""
