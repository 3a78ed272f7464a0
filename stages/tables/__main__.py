"""Command line of the `tables` stage."""

from roomkin.stages.cli import main

main(
    "roomkin.stages.tables",
    {
        "scenes": "Table 2 and Figure 6, with the paper's values beside ours",
        "policies": "Table 3, Figures 4 and 9, with the paper's values beside ours",
    },
)
