"""The default library's models without their meshes: what casting needs, made in two seconds."""

from functools import cache

from roomkin.plugins.furniture.catalogue import sample
from roomkin.plugins.furniture.folder import generate, robot_of
from roomkin.stages.articulated.asset_folder import contract_joints
from roomkin.stages.config.assets import AssetsConfig
from roomkin.stages.contracts import Asset


@cache
def default_models(seed: int) -> dict[str, Asset]:
    """Assets by id, with sizes, counts and handles but no files."""
    models = {}
    for category, count in sorted(AssetsConfig().counts.items()):
        for index in range(count):
            recipe = sample(category, index, seed)
            jointed = recipe.generator == "cabinet"
            joints = contract_joints(robot_of(generate(recipe), category)) if jointed else []
            name = f"{category}_{index:02d}"
            x, y, z = recipe.parameters["size"]  # type: ignore[misc]
            models[name] = Asset(
                id=name,
                category=category,
                box_min=(0, 0, 0),
                box_max=(x, y, z),
                mass=1.0,
                joints=joints,
                doors=sum(joint.part_type == "door" for joint in joints),
                drawers=sum(joint.part_type == "drawer" for joint in joints),
                licence="",
                provenance="",
                checksum="",
                recipe=recipe,
            )
    return models
