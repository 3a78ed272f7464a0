"""The report page: its sections, templates and style."""
