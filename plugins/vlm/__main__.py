"""`python -m plugins.vlm VERB --help`."""

from stages.cli import main

main(
    "plugins.vlm",
    {
        "cost": "what a ledger's calls have cost, by model",
        "diff": "where two models answered the same questions otherwise",
    },
)
