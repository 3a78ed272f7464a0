"""`python -m stages.scenes render --help`."""

from stages.cli import main

main("scenes", {"render": "furnish and photograph one room", "from-rgbd": "an RGB-D frame as an input folder"})
