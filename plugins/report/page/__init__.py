"""The report page: what it tells of each part of a run, its templates, its style."""
