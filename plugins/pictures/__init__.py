"""Pictures for people of what the stages wrote: models, objects, cousins, scenes."""
