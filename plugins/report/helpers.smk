# Helpers of the pages. Nothing here makes a file.
import subprocess


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
