"""The eight rooms of Table 2, a YAML file each (`plugins.scenes.recipe`)."""
