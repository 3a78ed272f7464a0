"""`python -m stages.evaluation VERB`."""

from stages.cli import main

main(
    "evaluation",
    {
        "rollout": "roll a policy out on the test assets",
        "score": "compare generated scenes with the truth",
    },
)
