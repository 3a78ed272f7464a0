"""`python -m stages.demonstrations COMMAND`."""

from stages.cli import main

if __name__ == "__main__":
    main(
        "stages.demonstrations",
        {
            "collect": "run the skill on one asset until enough attempts succeed",
        },
    )
