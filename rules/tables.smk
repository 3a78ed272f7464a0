# The paper's tables and figures with ours beside them, and the report page.
# Reads:  evaluation rows, the published values in report/published, pictures of the other stages.
#         (the page shows exactly the files that its rule names).
# Writes: results/tables/table{2,3}.{csv,html,tex}, results/figures/figure{4,6,9}.{svg,png},
#         results/report/{index,times}.html.
from types import SimpleNamespace

# A command in the place of our verb need not make films.
DEMO_FILMS = [] if "collect" in CONFIG.stages.get("demonstrations", {}) else trained(rules.demonstrate.output.films)
SCENE_FILMS = (
    [] if "scene" in CONFIG.stages.get("demonstrations", {}) else in_scenes(rules.demonstrate_in_scene.output.films)
)
ROLLOUT_FILMS = (
    [] if "rollout" in CONFIG.stages.get("evaluation", {}) else policies(rules.rollout.output.films, first=True)
)
# Benchmark files cannot be inputs: those of this run are named to the page, so that it counts no others.
BENCHMARKS = [
    rules.library.benchmark,
    *expand(rules.snapshots.benchmark, shard=SHARDS),
    *expand(rules.room.benchmark, scene=SCORED_ROOMS),
    *expand(rules.extract.benchmark, scene=ROOMS),
    *expand(rules.features.benchmark, store=STORES, shard=SHARDS),
    *expand(
        [rules.match.benchmark, rules.generate.benchmark, rules.draw_scenes.benchmark], variant=VARIANTS, scene=ROOMS
    ),
    *expand(rules.score.benchmark, variant=VARIANTS, scene=SCORED_ROOMS),
    *expand(rules.select.benchmark, variant=EXPERIMENT.policy_variant, task=TASKS),
    *[
        file
        for task in TASKS
        for file in of_target(SimpleNamespace(task=task, variant=EXPERIMENT.policy_variant), rules.distances.benchmark)
    ],
    *trained(rules.demonstrate.benchmark),
    *in_scenes(rules.demonstrate_in_scene.benchmark),
    *possible_policies([rules.train.benchmark, rules.trial.benchmark, rules.rollout.benchmark]),
    "benchmarks/tables/tables.tsv",
    "benchmarks/tables/figures.tsv",
]


rule tables:
    """Tables 2 and 3: every cell with its n, seeds and interval, the published value beside it."""
    input:
        scores=expand(rules.score.output.scores, variant=VARIANTS, scene=SCORED_ROOMS),
        rollouts=cells(rules.gather.output.rollouts),
        published_scenes="report/published/table2.csv",
        published_policies="report/published/table3.csv",
    output:
        table2="results/tables/table2.csv",
        table3="results/tables/table3.csv",
        more=expand("results/tables/table3_{what}.csv", what=["differences", "claims", "stability"]),
        html2=shown("results/tables/table2.html", "tables"),
        html3=shown("results/tables/table3.html", "tables"),
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
        options=options("tables", "tables"),
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
        figure4=shown("results/figures/figure4.svg", "figures"),
        figure6=shown("results/figures/figure6.svg", "figures"),
        figure9=shown("results/figures/figure9.svg", "figures"),
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
        options=options("tables", "figures"),
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
    """One page that shows this run: what these inputs hold, and nothing else that lies in results/."""
    input:
        library=rules.library.output.library,
        snapshots=expand([*rules.snapshots.output], shard=SHARDS),
        sheets=rules.draw_snapshots.output.sheets,
        images=[scene_image(SimpleNamespace(scene=room)) for room in ROOMS],
        objects=expand(rules.extract.output.objects, scene=ROOMS),
        overviews=expand(rules.draw_objects.output.overview, scene=ROOMS),
        cousins=expand(rules.match.output.cousins, variant=VARIANTS, scene=ROOMS),
        scenes=expand(rules.generate.output.scenes, variant=VARIANTS, scene=ROOMS),
        previews=expand(rules.draw_scenes.output.previews, variant=VARIANTS, scene=ROOMS),
        assets=[task_assets(task) for task in TASKS],
        films=DEMO_FILMS,
        scene_films=SCENE_FILMS,
        rollout_films=ROLLOUT_FILMS,
        in_scene=in_scenes(rules.demonstrate_in_scene.output.in_scene),
        attempts=trained(rules.demonstrate.output.attempts),
        metrics=policies(rules.train.output.metrics, first=True),
        tables=rules.tables.output,
        figures=rules.figures.output,
    output:
        page=shown("results/report/index.html", "report"),
        times="results/report/times.html",
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
        options=options("tables", "report"),
        images=lambda wildcards, input: [f"{room}={image}" for room, image in zip(ROOMS, input.images)],
        benchmarks=BENCHMARKS,
        seed=CONFIG.seed,
        digest=config_digest(),
    shell:
        "{params.command} --files {input:q} --images {params.images:q} --benchmarks {params.benchmarks:q} "
        "--seed {params.seed} --config-digest {params.digest} --options {params.options:q} "
        "--out {output.page:q} 2>&1 | tee {log:q}"
