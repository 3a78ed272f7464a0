"""`roomkin scorecard COMMAND --help`."""

from roomkin.stages.cli import main

if __name__ == "__main__":
    main(
        "roomkin.plugins.scorecard",
        {
            "score": "a submission against the truth of a set of rooms: rows, a table row, a page",
            "baselines": "submissions of the dumbest methods, for the same rooms",
        },
    )
