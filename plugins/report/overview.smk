# One page over all scenes of a run: what came of each, what failed and why.


container: CONFIG.containers.report


rule overview_page:
    """Every scene as a row: pictures of input and rank 1, what failed and why, doubts."""
    input:
        objects=expand("results/extraction/{scene}/objects.json", scene=ROOMS),
        cousins=expand("results/matching/{variant}/{scene}/cousins.json", scene=ROOMS, allow_missing=True),
        scenes=expand(
            "results/generation/{variant}/{scene}/scene_{rank}.json", rank=RANKS, scene=ROOMS, allow_missing=True
        ),
        thumbnails=expand("results/generation/{variant}/{scene}/thumbnail.webp", scene=ROOMS, allow_missing=True),
        pages=lambda wildcards: own_pages(ROOMS),
    output:
        page="results/report/overview/{variant}.html",
    log:
        "logs/tables/overview_{variant}.log",
    localrule: True
    resources:
        **needs(2000, 30),
    params:
        **command("report", "overview"),
        results=lambda wildcards, input: input.objects[0].partition("extraction/")[0],
        scenes=ROOMS,
    shell:
        "{params.command} --scenes {params.scenes} --variant {wildcards.variant} --results {params.results:q} "
        "--pages {input.pages:q} "
        "--out {output.page:q} 2>&1 | tee {log:q}"


rule overview:
    """One page over all scenes, for every variant."""
    input:
        expand("results/report/overview/{variant}.html", variant=VARIANTS),
    localrule: True
