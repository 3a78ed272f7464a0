"""`python -m stages.inputs VERB --help`."""

from stages.cli import main

main(
    "stages.inputs",
    {
        "from-rgbd": "an RGB-D frame as an input folder",
        "annotate": "draw camera, room and objects into a photograph by hand, in the browser",
        "estimate": "a picture as an input folder, by pretrained networks",
        "fetch": "download their weights, once",
    },
)
