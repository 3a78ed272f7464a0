"""Command line of the `tables` stage."""

from stages.cli import main

main(
    "tables",
    {
        "scenes": "Table 2, its companion and Figure 6, with the paper's values beside ours",
        "policies": "Table 3 and what goes with it as CSV, HTML and LaTeX, with the paper's values beside ours",
        "figures": "Figures 4 and 9 as SVG and PNG",
        "results": "what a study found, as Markdown, CSV and figures for docs/results",
        "scene_results": "the same of a study of Table 2",
        "report": "one self-contained page about the whole run",
        "overview": "every scene of a run as a row of one page",
        "picture": "one self-contained page about one picture and what became of it",
    },
)
