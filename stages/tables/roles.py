"""The assets of a policy experiment: who is who, what a policy meets there, and what it has met in training."""

from collections.abc import Iterable

from stages.contracts.policies import TaskAsset, TaskAssets
from stages.tables.markup import Cell, Row, Table, number
from stages.tables.order import title


def kind_of(asset: TaskAsset) -> str:
    """What a gripper meets: 'bar, hinge left'; 'knob, slide'."""
    return f"{asset.handle}, {'slide' if asset.hinge == 'slide' else f'hinge {asset.hinge}'}"


def known_kinds(chosen: TaskAssets, demonstrated: Iterable[str]) -> set[str]:
    """What the assets in the demonstrated roles have; `all`: all of `all_assets`."""
    roles = set(demonstrated)
    shown = [asset for asset in chosen.assets if asset.role in roles]
    return {kind_of(asset) for asset in [*shown, *(chosen.all_assets if "all" in roles else [])]}


def roles_table(chosen: TaskAssets, demonstrated: Iterable[str], name: str, caption: str) -> Table:
    """A row per role; `demonstrated`: roles on which demonstrations are collected, `all` for all of `all_assets`."""
    roles = set(demonstrated)
    known = known_kinds(chosen, roles)
    in_all = {asset.asset for asset in chosen.all_assets} if "all" in roles else set()
    rows = []
    for asset in chosen.assets:
        used = "yes" if asset.role in roles else "in all assets" if asset.asset in in_all else "no"
        width, height = asset.panel_size
        rows.append(
            Row(
                [
                    Cell(title(asset.role)), Cell(asset.asset), Cell(number(asset.distance, 2)), Cell(kind_of(asset)),
                    Cell(f"{asset.panel_height:.2f} m", f"{width:.2f} x {height:.2f} m"), Cell(used),
                    Cell("yes" if kind_of(asset) in known else "no"),
                ]
            )
        )  # fmt: skip
    return Table(
        name=name,
        caption=caption,
        columns=["Role", "Model", "Distance", "Handle", "Panel", "Demonstrated", "Handle known"],
        rows=rows,
        notes=[
            "Distance to the twin under the encoder of the run. Panel: height of its centre above the bottom of the "
            "asset, width x height. Handle known: some demonstrated asset has a handle of this kind on a panel that "
            "hangs alike."
        ],
    )
