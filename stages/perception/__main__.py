"""`roomkin perception COMMAND --help`."""

from roomkin.stages.cli import main

if __name__ == "__main__":
    main(
        "roomkin.stages.perception",
        {
            "from-rgbd": "an RGB-D frame as an input folder",
            "measure": "depth of a photograph by a network, for `see`",
            "see": "find and name the things of a picture with depth",
            "draw": "a photograph without depth as an input folder, by lines and usual sizes",
            "fetch": "download published weights, once",
        },
    )
