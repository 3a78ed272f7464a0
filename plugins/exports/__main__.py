"""`python -m plugins.exports COMMAND --help`."""

from stages.cli import main

if __name__ == "__main__":
    main(
        "plugins.exports",
        {
            "scenes": "generated scenes as GLB, URDF, MJCF or USD",
            "demonstrations": "episode stores in the formats of robomimic, lerobot and ManiSkill",
            "policy": "a policy with a loader that needs torch and safetensors alone",
        },
    )
