"""`roomkin ops COMMAND --help`."""

from roomkin.stages.cli import main

if __name__ == "__main__":
    main(
        "roomkin.plugins.ops",
        {
            "clean": "delete what runs wrote, and nothing that a person made",
            "cluster": "what a SLURM cluster has and lacks, from one of its login nodes",
            "verify": "finished results against what the run recorded of them",
        },
    )
