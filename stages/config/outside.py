"""Files of the user's that a run reads: containers have to see those that lie outside the working directory."""

from pathlib import Path

from stages import plugins
from stages.config.matching import MatchingConfig
from stages.config.model import Config


def outside(config: Config) -> list[str]:
    """Absolute paths, outside the working directory, of what the config names: scenes, models, weights, code."""
    commands = [own for verbs in config.stages.values() for own in verbs.values()]
    matching = [config.matching, *map(config.matching_of, config.experiment.variants)]
    named = [
        *config.experiment.inputs.values(),
        *config.experiment.room_files,
        *(target.assets for target in config.experiment.tasks.values() if target.assets),
        *_of_picture(config),
        *config.assets.folders,
        *(name for own in commands for name in own.code),
        *(path for options in matching for path in _weights(options)),
        *(str(plugins.folder(package)) for package in config.plugins),
    ]
    paths = {Path(name).resolve() for name in named if Path(name).exists()}
    return sorted(str(path) for path in paths if not path.is_relative_to(Path.cwd()))


def _of_picture(config: Config) -> list[str]:
    if not config.image:
        return []
    ledger = [] if "vlm" in config.photo.unread() else [config.photo.vlm.ledger]
    return [config.image, *(network.path for network in config.photo.networks().values()), *ledger]


def _weights(options: MatchingConfig) -> list[str]:
    used = [options.dinov2.path, options.clip.path, "" if "vlm" in options.unread() else options.vlm.ledger]
    return [path for path in used if path]
