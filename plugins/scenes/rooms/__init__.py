"""The eight rooms of Table 2, a YAML file each (`roomkin.plugins.scenes.recipe`)."""
