# One page over all scenes of a run: what came of each, what failed and why.


rule overview_page:
    """Every scene as a row: pictures of input and rank 1, what failed and why, doubts."""
    input:
        objects=files(rules.extract.output.objects, scene=ROOMS),
        cousins=files(rules.match.output.cousins, scene=ROOMS),
        scenes=files(rules.generate.output.scenes, scene=ROOMS),
        thumbnails=files(rules.draw_scenes.output.thumbnail, scene=ROOMS),
        pages=lambda wildcards: own_pages(ROOMS),
    output:
        page=in_report("results/report/overview/{variant}.html", "report", "../../report/captions"),
    log:
        "logs/tables/overview_{variant}.log",
    localrule: True
    container:
        CONFIG.containers.report
    threads: 1
    resources:
        **needs(2000, 30),
    params:
        command=command("report", "overview"),
        code=code("report", "overview"),
        results=lambda wildcards, input: input.objects[0].partition("extraction/")[0],
        scenes=ROOMS,
    shell:
        "{params.command} --scenes {params.scenes} --variant {wildcards.variant} --results {params.results:q} "
        "--pages {input.pages:q} "
        "--out {output.page:q} 2>&1 | tee {log:q}"


rule overview:
    """One page over all scenes, for every variant."""
    input:
        files(rules.overview_page.output.page, variant=VARIANTS),
    localrule: True
