# Helpers of the pages. Nothing here makes a file.
import subprocess
from types import SimpleNamespace


def of_picture(pattern):
    """A function of what Snakemake calls a job's inputs: the files of `pattern` for the picture of this run."""

    def found(wildcards):
        if not CONFIG.image:
            raise WorkflowError("image: there is no picture. Fix: snakemake --cores 2 photo --config image=kitchen.jpg")
        return files(pattern, variant=VARIANTS, scene=ROOMS)

    return found


def own_pages(scenes):
    """The scenes' own pages that are there, or are asked for: other pages link to them."""
    asked, paths = "pages" in workflow.dag_settings.targets, files(rules.scene_page.output.page, scene=scenes)
    return [path for path in paths if asked or Path(str(path)).is_file()]


def tell_of_failures():
    """After a failed run of many scenes: the same pages of what there is, with where and why scenes stopped."""
    for variant in VARIANTS if MORE and workflow.exec_mode == ExecMode.DEFAULT else []:
        page = files(rules.overview_page.output.page, variant=variant)[0].removesuffix("html") + "failed.html"
        line = [*shlex.split(command("report", "overview")), "--variant", variant, "--out", page, "--scenes", *ROOMS]
        subprocess.run(line)


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
    *expand("benchmarks/assets/procedural_{shard}.tsv", shard=range(PROCEDURAL)),
    *expand("benchmarks/assets/{shard}.tsv", shard=OWN),
    *files(rules.snapshots.benchmark, shard=SHARDS),
    *files(rules.room.benchmark, scene=SCORED_ROOMS),
    *files(rules.extract.benchmark, scene=SHOWN),
    *files(rules.features.benchmark, store=STORES, shard=SHARDS),
    *files(
        [rules.match.benchmark, rules.generate.benchmark, rules.draw_scenes.benchmark], variant=VARIANTS, scene=SHOWN
    ),
    *files(rules.score.benchmark, variant=VARIANTS, scene=SCORED_ROOMS),
    *files(rules.select.benchmark, variant=EXPERIMENT.policy_variant, target=TARGETS),
    *[
        file
        for name in TARGETS
        if name not in PINNED
        for file in of_target(
            SimpleNamespace(target=name, variant=EXPERIMENT.policy_variant), rules.distances.benchmark
        )
    ],
    *trained(rules.demonstrate.benchmark),
    *in_scenes(rules.demonstrate_in_scene.benchmark),
    *demonstrated(rules.skill.benchmark),
    *possible_policies([rules.train.benchmark, rules.trial.benchmark, rules.rollout.benchmark]),
    *met([rules.room.benchmark, rules.extract.benchmark, rules.match.benchmark, rules.generate.benchmark]),
    *met(rules.score.benchmark),
    *expand("benchmarks/tables/{table}.tsv", table=["table2", "table3"]),
]
