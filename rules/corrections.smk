# Helpers: what a person says of a scene in corrections.json, and which rules it concerns. Nothing here makes a file.


def corrections(stage):
    """A function of what Snakemake calls a job's inputs: corrections.json beside the picture if a stage reads it there.

    That it is newer says nothing: `corrected` tells what of it the stage reads.
    """

    def found(wildcards):
        path = corrections_file(wildcards)
        return [ancient(str(path))] if corrected(stage)(wildcards) else []

    return found


def corrected(stage):
    """A parameter: what a stage reads of corrections.json, so that no other correction runs it; empty: nothing."""

    def told(wildcards):
        path = corrections_file(wildcards)
        try:
            said = corrections_of((path,) if path.is_file() else (), stage)
        except InputError as error:
            raise WorkflowError(str(error)) from None
        return "".join(item.model_dump_json(exclude_defaults=True) for item in said.values())

    return told


def corrector_code(wildcards, input):
    """Digest of the code that applies corrections in extraction; empty: there are none."""
    return code_digest(qualify_module("correctors", find("correctors", "by_hand"))) if input.corrections else ""


def corrections_file(wildcards):
    """It lies beside a scene's camera.json."""
    return Path(scene_inputs(wildcards)["camera"]).with_name(CORRECTIONS)


def corrections_flag(wildcards, input):
    """How a stage is told of them."""
    return shlex.join(["--corrections", *input.corrections]) if input.corrections else ""
