"""Command line of the `tables` stage."""

from stages.cli import main

main(
    "stages.tables",
    {
        "scenes": "Table 2, its robustness variants and Figure 6, with the paper's values beside ours",
        "trainings": "how every training ended, and which failed",
        "policies": "success over unseen assets, Table 3, Figures 4 and 9, with the paper's values beside ours",
        "conditions": "success in another simulator, under noise, ..., minus the usual",
        "viewer": "the script by which pages turn a scene",
        "report": "one page about the whole run",
        "overview": "every scene of a run as a row of one page",
        "picture": "one page about one picture and what became of it",
    },
)
