"""Pages for people: one about a run, one about a picture, one about many pictures (docs/tables.md)."""
