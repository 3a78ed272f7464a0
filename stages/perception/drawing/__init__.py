"""project.json: a room as a person draws it, solved and written as an input folder."""
