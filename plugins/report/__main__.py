"""`roomkin report COMMAND --help`."""

from roomkin.stages.cli import main

if __name__ == "__main__":
    main(
        "roomkin.plugins.report",
        {
            "viewer": "the script by which pages turn a scene",
            "report": "one page about the whole run",
            "overview": "every scene of a run as a row of one page",
            "picture": "one page about one picture and what became of it",
        },
    )
