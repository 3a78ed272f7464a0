"""`roomkin importing COMMAND --help`."""

from roomkin.stages.cli import main

if __name__ == "__main__":
    main(
        "roomkin.plugins.importing",
        {
            "import": "look at a folder of models: what each is taken for, to correct, and a page of pictures",
            "own": "import some models of a user's folder",
        },
    )
