"""`roomkin studies COMMAND --help`."""

from roomkin.stages.cli import main

if __name__ == "__main__":
    main(
        "roomkin.plugins.studies",
        {
            "conditions": "success in another simulator, under noise, ..., minus the usual",
            "objects": "what cousins add at each of many objects, and over them",
            "pinned": "take the assets of a target from a committed file, if the library has the very same models",
            "quote": "write the figures that README and guides take from docs/results",
            "results": "what a study found, as Markdown, CSV and figures for docs/results",
        },
    )
