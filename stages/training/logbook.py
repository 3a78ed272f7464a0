"""Training curves: metrics.jsonl, and optionally a Weights & Biases run (offline by default: no network, no key)."""

import json
import sys
from pathlib import Path
from typing import Any, Literal

from roomkin.stages.contracts.system import name_file_in_errors

Line = dict[str, float | int | None]
Mode = Literal["disabled", "offline", "online"]


class Logbook:
    """Appends lines to a metrics file; a resumed run goes on behind the lines it had."""

    def __init__(self, path: Path, lines: list[Line], wandb_mode: Mode, folder: Path, config: dict[str, Any]) -> None:
        self.path = path
        with name_file_in_errors(path):
            self.path.write_text("".join(json.dumps(line) + "\n" for line in lines), encoding="utf-8")
        self.run = start_wandb(wandb_mode, folder, config)
        for line in lines:
            self._mirror(line)

    def write(self, line: Line) -> None:
        """Append one line."""
        with name_file_in_errors(self.path), self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")
        self._mirror(line)

    def close(self) -> None:
        """Finish the Weights & Biases run."""
        if self.run is not None:
            self.run.finish()

    def _mirror(self, line: Line) -> None:
        if self.run is not None:
            self.run.log({name: value for name, value in line.items() if name != "step"}, step=int(line["step"] or 0))


def start_wandb(mode: Mode, folder: Path, config: dict[str, Any]) -> Any:
    """A run that writes below `folder`/wandb, or None where it is switched off or cannot start."""
    if mode == "disabled":
        return None
    try:
        import wandb

        folder.mkdir(parents=True, exist_ok=True)
        return wandb.init(
            project="acdc",
            mode=mode,
            dir=folder,
            config=config,
            settings=wandb.Settings(
                silent=True,
                console="off",
                x_disable_stats=True,
                x_disable_meta=True,
                disable_git=True,
                disable_code=True,
            ),
        )
    except Exception as error:  # a logger must not end a training run, whatever it stumbles over
        print(f"warning: no Weights & Biases run: {error}", file=sys.stderr)
        return None
