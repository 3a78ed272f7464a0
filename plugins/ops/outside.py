"""Outside needs of a run's containers: files of the user's, the network, keys."""

from collections import Counter
from pathlib import Path

from roomkin.stages import plugins
from roomkin.stages.config.model import Config
from roomkin.stages.config.packages import packages_on

MANY = 8  # files in one folder: containers see it whole then


def list_outside_paths(config: Config) -> list[str]:
    """Absolute paths, outside the working directory, of what the config names: scenes, models, weights, code."""
    commands = [own for stage in config.stages.values() for own in stage.values()]
    matching = map(config.matching_of, config.experiment.variants)
    named = [
        *_of_inputs(config),
        *(target.assets for target in config.experiment.targets.values() if target.assets),
        *config.assets.folders,
        *(name for own in commands for name in own.code),
        *(path for options in matching for path in options.weights().values() if path),
        *(path for package in packages_on(config.packages) for path in package.outside(config)),
        *(str(plugins.folder(package)) for package in config.plugins),
    ]
    paths = {Path(name).resolve() for name in named if Path(name).exists()}
    return sorted(str(path) for path in paths if not path.is_relative_to(Path.cwd()))


def list_key_variables(config: Config) -> list[str] | None:
    """Environment variables that hold keys of the servers that are asked; None: nothing asks the network."""
    keys = [found for package in packages_on(config.packages) if (found := package.keys(config)) is not None]
    return sorted({name for found in keys for name in found} - {""}) if keys else None


def container_environment(config: Config, published: str) -> dict[str, str]:
    """Environment variables for containers/podman-shell: images, folders to mount, keys if the network is used, a GPU.

    Args:
        published: folder of the tables of the paper's values.
    """
    keys = list_key_variables(config)
    return {
        "ACDC_IMAGE": config.containers.template,
        "ACDC_OUTSIDE": "\n".join([*list_outside_paths(config), published]),
        "ACDC_CODE": str(plugins.PACKAGES.parent),
        "ACDC_GPU": config.device.replace("cpu", ""),
    } | ({} if keys is None else {"ACDC_ONLINE": " ".join(keys)})


def _of_inputs(config: Config) -> list[str]:
    """The user's pictures, or, where they are many, the folders that these lie in."""
    inputs = [config.experiment.inputs[room] for room in config.experiment.rooms if room in config.experiment.inputs]
    files = [path for given in inputs for path in given.files().values()]
    folders = Counter(str(Path(path).parent) for path in files)
    return [*dict.fromkeys(folder if folders[folder := str(Path(path).parent)] > MANY else path for path in files)]
