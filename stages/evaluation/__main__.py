"""`python -m stages.evaluation VERB`."""

from stages.cli import main

main(
    "stages.evaluation",
    {
        "trial": "roll the checkpoints of a policy out on the twin",
        "choose": "choose hyper-parameter sets by their trials",
        "rollout": "roll a policy out on the test assets",
        "gather": "put the rollouts of a training set into one table",
        "score": "compare generated scenes with the truth",
    },
)
