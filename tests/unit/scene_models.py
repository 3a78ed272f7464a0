"""The default library's models without their meshes: what casting needs, made in a second."""

from functools import cache

from stages.config.assets import AssetsConfig
from stages.contracts import Asset
from stages.procedural.catalogue import sample
from stages.procedural.folder import generate, joints_of


@cache
def default_models(seed: int) -> dict[str, Asset]:
    """Assets by id, with sizes, counts and handles but no files."""
    models = {}
    for category, count in sorted(AssetsConfig().counts.items()):
        for index in range(count):
            recipe = sample(category, index, seed)
            model = generate(recipe)
            name = f"{category}_{index:02d}"
            x, y, z = recipe.parameters["size"]  # type: ignore[misc]
            models[name] = Asset(
                id=name,
                category=category,
                box_min=(0, 0, 0),
                box_max=(x, y, z),
                mass=1.0,
                joints=joints_of(model),
                doors=sum(moving.role == "door" for moving in model.moving),
                drawers=sum(moving.role == "drawer" for moving in model.moving),
                symmetry=model.symmetry,
                placement=model.placement,
                licence="",
                provenance="",
                checksum="",
            )
    return models
