"""`python -m stages.vlm VERB --help`."""

from stages.cli import main

main(
    "stages.vlm",
    {
        "cost": "what a ledger's calls have cost, by model",
        "diff": "where two models answered the same questions otherwise",
    },
)
