"""`python -m plugins.inputs VERB --help`."""

from stages.cli import main

main(
    "plugins.inputs",
    {
        "from-rgbd": "an RGB-D frame as an input folder",
        "estimate": "a picture as an input folder, by pretrained networks",
        "fetch": "download their weights, once",
    },
)
