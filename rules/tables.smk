# The paper's tables and figures with ours beside them, and the report page.
# Reads:  evaluation rows, the published values in report/published, pictures of the other stages.
# Writes: results/tables/table{2,3}.{csv,html,tex}, results/figures/figure{4,6,9}.{svg,png}, results/report/index.html.


rule tables:
    """Tables 2 and 3: every cell with its n, seeds and interval, the published value beside it."""
    input:
        scores=expand(rules.score.output.scores, variant=VARIANTS, scene=SCORED_ROOMS),
        rollouts=[
            f"{folder}/rollouts.csv"
            for task in TASKS
            for folder in policy_folders(task, "results/evaluation/policies")
        ],
        published_scenes="report/published/table2.csv",
        published_policies="report/published/table3.csv",
    output:
        table2="results/tables/table2.csv",
        table3="results/tables/table3.csv",
        differences="results/tables/table3_differences.csv",
        html2=report("results/tables/table2.html", caption="../report/captions/tables.rst", category="Tables"),
        html3=report("results/tables/table3.html", caption="../report/captions/tables.rst", category="Tables"),
        tex=expand("results/tables/{table}.tex", table=["table2", "table3"]),
    log:
        "logs/tables/tables.log",
    benchmark:
        "benchmarks/tables/tables.tsv"
    container:
        CONFIG.containers.report
    threads: 1
    resources:
        mem_mb=1000,
    params:
        command=command("tables", "tables"),
        code=code("tables", "tables"),
        options=as_options(CONFIG.tables),
        published=subpath(input.published_scenes, parent=True),
        out=subpath(output.table2, parent=True),
    shell:
        "{params.command} --scores {input.scores:q} --rollouts {input.rollouts:q} "
        "--published {params.published:q} --options {params.options:q} --out {params.out:q} 2>&1 | tee {log:q}"


rule figures:
    """Figures 4, 6 and 9."""
    input:
        table3=rules.tables.output.table3,
        published="report/published/table3.csv",
        comparisons=expand(rules.draw_scenes.output.comparison, variant=VARIANTS, scene=ROOMS),
    output:
        figure4=report("results/figures/figure4.svg", caption="../report/captions/figures.rst", category="Figures"),
        figure6=report("results/figures/figure6.svg", caption="../report/captions/figures.rst", category="Figures"),
        figure9=report("results/figures/figure9.svg", caption="../report/captions/figures.rst", category="Figures"),
        png=expand("results/figures/{figure}.png", figure=["figure4", "figure6", "figure9"]),
    log:
        "logs/tables/figures.log",
    benchmark:
        "benchmarks/tables/figures.tsv"
    container:
        CONFIG.containers.report
    threads: 1
    resources:
        mem_mb=1000,
    params:
        command=command("tables", "figures"),
        code=code("tables", "figures"),
        options=as_options(CONFIG.tables),
        published=subpath(input.published, parent=True),
        comparisons=[
            f"{room}/{variant}=results/generation/{variant}/{room}/comparison.png"
            for room in ROOMS
            for variant in VARIANTS
        ],
        out=subpath(output.figure4, parent=True),
    shell:
        "{params.command} --table3-csv {input.table3:q} --published {params.published:q} "
        "--comparisons {params.comparisons:q} --options {params.options:q} --out {params.out:q} 2>&1 | tee {log:q}"


rule report_page:
    """One page that shows the whole run."""
    input:
        rules.draw_snapshots.output,
        rules.extraction.input,
        rules.matching.input,
        rules.generation.input,
        rules.demonstrations.input,
        rules.training.input,
        rules.evaluation.input,
        rules.tables.output,
        rules.figures.output,
    output:
        page=report(
            "results/report/index.html",
            caption="../report/captions/report.rst",
            category="Report",
        ),
    log:
        "logs/tables/report.log",
    container:
        CONFIG.containers.report
    threads: 1
    resources:
        mem_mb=1000,
    params:
        command=command("tables", "report"),
        code=code("tables", "report"),
        options=as_options(CONFIG.tables),
        seed=CONFIG.seed,
        digest=config_digest(),
    shell:
        "{params.command} --results results --benchmarks benchmarks --tables results/tables "
        "--figures results/figures --seed {params.seed} --config-digest {params.digest} --options {params.options:q} --out {output.page:q} 2>&1 | tee {log:q}"
