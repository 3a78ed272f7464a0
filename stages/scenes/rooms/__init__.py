"""The eight rooms of Table 2, a YAML file each (`stages.config.room_recipe`)."""
