"""`python -m plugins.furniture COMMAND --help`."""

from stages.cli import main

if __name__ == "__main__":
    main(
        "plugins.furniture",
        {
            "library": "make the procedural models",
            "facts": "write what others know of the categories: names, likes, usual sizes",
        },
    )
