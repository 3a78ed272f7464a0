"""`roomkin furniture COMMAND --help`."""

from roomkin.stages.cli import main

if __name__ == "__main__":
    main(
        "roomkin.plugins.furniture",
        {
            "library": "make the procedural models",
            "facts": "write what others know of the categories: names, likes, usual sizes",
        },
    )
