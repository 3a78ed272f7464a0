"""`python -m stages.training VERB`."""

from stages.cli import main

main(
    "training",
    {
        "train": "train one policy on episode stores",
        "export": "a policy with a loader that needs torch and safetensors alone",
    },
)
