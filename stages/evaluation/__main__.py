"""`roomkin evaluation COMMAND`."""

from roomkin.stages.cli import main

main(
    "roomkin.stages.evaluation",
    {
        "selection-rollout": "roll the checkpoints of a policy out on the twin",
        "choose": "choose policy configs by their selection rollouts",
        "rollout": "roll a policy out on the test assets",
        "merge": "put the rollouts of a training set into one table",
        "score": "compare generated scenes with the truth",
    },
)
