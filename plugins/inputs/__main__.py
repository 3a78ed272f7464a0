"""`python -m plugins.inputs COMMAND --help`."""

from stages.cli import main

main(
    "plugins.inputs",
    {
        "from-rgbd": "an RGB-D frame as an input folder",
        "estimate": "a picture as an input folder, by pretrained networks",
        "fetch": "download their weights, once",
    },
)
