"""`python -m stages.photo VERB --help`."""

from stages.cli import main

main(
    "photo",
    {
        "estimate": "a picture as an input folder, by pretrained networks",
        "fetch": "download their weights, once",
    },
)
