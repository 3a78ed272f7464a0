"""`roomkin exports COMMAND --help`."""

from roomkin.stages.cli import main

if __name__ == "__main__":
    main(
        "roomkin.plugins.exports",
        {
            "scenes": "generated scenes as GLB, URDF, MJCF or USD",
            "demonstrations": "episode stores in the formats of robomimic, lerobot and ManiSkill",
            "policy": "a policy with a loader that needs torch and safetensors alone",
        },
    )
