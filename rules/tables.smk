# The paper's tables and figures with ours beside them.
# Reads:  evaluation rows, how trainings ended, the published values in report/published, pictures of the generated scenes.
# Writes: results/tables/{table2,table3,assets}.{csv,html,tex}, results/figures/figure{4,6,9}.{svg,png}.


container: CONFIG.containers.report


rule table2:
    """Table 2 and Figure 6, the published values beside ours."""
    input:
        scores=expand("results/evaluation/scenes/{variant}/{room}/scores.csv", variant=VARIANTS, room=SCORED_ROOMS),
        comparisons=added("figure6"),
    output:
        csv="results/tables/table2.csv",
        html="results/tables/table2.html",
        tex="results/tables/table2.tex",
        figure6="results/figures/figure6.svg",
        png="results/figures/figure6.png",
    log:
        "logs/tables/table2.log",
    benchmark:
        "benchmarks/tables/table2.tsv"
    localrule: True
    resources:
        **needs(1000, 10),
    params:
        **command("tables", "scenes"),
        paper=paper("table2"),
        comparisons=lambda wildcards, input: [
            f"{room}/{variant}={file}"
            for (room, variant), file in zip(product(REPORT_ROOMS, VARIANTS), input.comparisons)
        ],
        out=subpath(output.html, parent=True),
        figures=subpath(output.figure6, parent=True),
    shell:
        "{params.command} --scores {input.scores:q} --comparisons {params.comparisons:q} "
        '--published "$ACDC_PAPER" --options {params.options:q} --figures {params.figures:q} '
        "--out {params.out:q} 2>&1 | tee {log:q}"


rule table3:
    """Table 3: every cell with its n, seeds and interval; Figures 4 and 9; what packages add: success over unseen assets, claims."""
    input:
        rollouts=expand("results/evaluation/policies/{target}/{policy}/{training_set}/rollouts.csv", zip, **CELLS),
        skills=added("skills"),
        trainings=TRAININGS,
    output:
        csv="results/tables/table3.csv",
        more=expand("results/tables/table3_{what}.csv", what=["cells", "differences"]),
        added=(
            [
                expand(
                    "results/tables/{table}.csv",
                    table=["table3_claims", "table3_stability", "assets", "assets_by_handle"],
                ),
                "results/tables/assets.html",
                "results/tables/assets.tex",
            ]
            if MORE_TABLES
            else []
        ),
        html="results/tables/table3.html",
        tex="results/tables/table3.tex",
        figure4="results/figures/figure4.svg",
        figure9="results/figures/figure9.svg",
        png=expand("results/figures/{figure}.png", figure=["figure4", "figure9"]),
    log:
        "logs/tables/table3.log",
    benchmark:
        "benchmarks/tables/table3.tsv"
    localrule: True
    resources:
        **needs(1000, 10),
    params:
        **command("tables", "policies", uses=MORE_TABLES),
        paper=paper("table3"),
        modules=MORE_TABLES,
        out=subpath(output.csv, parent=True),
        figures=subpath(output.figure4, parent=True),
    shell:
        "{params.command} --rollouts {input.rollouts:q} {input.skills:q} --more {params.modules:q} --trainings {input.trainings:q} "
        '--published "$ACDC_PAPER" --options {params.options:q} '
        "--figures {params.figures:q} --out {params.out:q} 2>&1 | tee {log:q}"


rule tables:
    """Tables 2 and 3, Figures 4, 6 and 9, how trainings ended."""
    input:
        TRAININGS,
        rules.table2.output,
        added("table2"),
        rules.table3.output,
    localrule: True


rule figures:
    """Figures 4, 6 and 9."""
    input:
        "results/figures/figure4.svg",
        "results/figures/figure6.svg",
        "results/figures/figure9.svg",
    localrule: True
