"""`roomkin annotator COMMAND --help`."""

from roomkin.stages.cli import main

if __name__ == "__main__":
    main(
        "roomkin.plugins.annotator",
        {
            "annotate": "draw camera, room and objects into a photograph by hand, in the browser; put a scene right",
            "after": "what make picture ends with: the page of its scene, where there is a browser",
        },
    )
