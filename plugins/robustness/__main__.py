"""`roomkin robustness COMMAND --help`."""

from roomkin.stages.cli import main

if __name__ == "__main__":
    main(
        "roomkin.plugins.robustness",
        {
            "leave_out": "name the true models of a room, for matching to do without",
            "table": "the companion of Table 2: the rooms changed, and drawn anew",
        },
    )
