"""Command line of the `tables` stage."""

from stages.cli import main

main(
    "tables",
    {
        "tables": "Tables 2 and 3 as CSV, HTML and LaTeX, with the paper's values beside ours",
        "figures": "Figures 4, 6 and 9 as SVG and PNG",
        "results": "what a study found, as Markdown, CSV and figures for docs/results",
        "report": "one self-contained page about the whole run",
    },
)
