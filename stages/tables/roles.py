"""The assets of a policy experiment: who is who, what a policy meets there, and what it has met in training."""

from collections import Counter
from collections.abc import Iterable

from stages.contracts.policies import TaskAsset, TaskAssets
from stages.tables.markup import Cell, Row, Table, number
from stages.tables.order import role_title


def kind_of(asset: TaskAsset) -> str:
    """What a gripper meets: 'bar, hinge left'; 'knob, slide'."""
    return f"{asset.handle}, {'slide' if asset.hinge == 'slide' else f'hinge {asset.hinge}'}"


def by_role(chosen: TaskAssets) -> dict[str, TaskAsset]:
    """The assets that play a role alone; those drawn by chance are random_1, random_2, ... as in training sets."""
    drawn = {f"random_{number}": asset for number, asset in enumerate(chosen.random_assets, start=1)}
    return {asset.role: asset for asset in chosen.assets} | drawn


def demonstrated_assets(chosen: TaskAssets, roles: Iterable[str]) -> list[TaskAsset]:
    """The assets on which the demonstrations of some roles are collected; of twin_randomised it is the twin."""
    known = by_role(chosen)
    shown = [known[name] for role in roles if (name := role.removesuffix("_randomised")) in known]
    return [*shown, *(chosen.all_assets if "all" in roles else [])]


def known_kinds(chosen: TaskAssets, demonstrated: Iterable[str]) -> set[str]:
    """What the assets in the demonstrated roles have; `all`: all of `all_assets`."""
    return {kind_of(asset) for asset in demonstrated_assets(chosen, set(demonstrated))}


def _used(role: str, asset: TaskAsset, roles: set[str], in_all: set[str]) -> str:
    ways = ["yes"] if role in roles else ["in all assets"] if asset.asset in in_all else []
    return ", ".join([*ways, *(["randomised"] if f"{role}_randomised" in roles else [])]) or "no"


def roles_table(chosen: TaskAssets, demonstrated: Iterable[str], name: str, caption: str) -> Table:
    """A row per role; `demonstrated`: roles on which demonstrations are collected, `all` for all of `all_assets`."""
    roles = set(demonstrated)
    known = known_kinds(chosen, roles)
    in_all = {asset.asset for asset in chosen.all_assets} if "all" in roles else set()
    rows = []
    for role, asset in by_role(chosen).items():
        if role.startswith("random_") and role not in roles:
            continue
        width, height = asset.panel_size
        length = f"{100 * asset.handle_length:.0f} cm, at {100 * asset.handle_height:.0f} % of the front"
        rows.append(
            Row(
                [
                    Cell(role_title(role)), Cell(asset.asset), Cell(asset.family), Cell(number(asset.distance, 2)),
                    Cell(kind_of(asset), length), Cell(f"{asset.panel_height:.2f} m", f"{width:.2f} x {height:.2f} m"),
                    Cell(_used(role, asset, roles, in_all)), Cell("yes" if kind_of(asset) in known else "no"),
                ]
            )
        )  # fmt: skip
    return Table(
        name=name,
        caption=caption,
        columns=["Role", "Model", "Family", "Distance", "Handle", "Panel", "Demonstrated", "Handle known"],
        rows=rows,
        notes=[
            "Family: the model that it is a variation of, or itself. Distance to the twin under the encoder of the "
            "run. Handle: its kind, the side on which the front hangs, its length, its height on the front (0 %: lower "
            "edge). Panel: height of its centre above the bottom of the asset, width x height. Handle known: some "
            "demonstrated asset has a handle of this kind on a panel that hangs alike."
        ],
    )


def lists_table(chosen: TaskAssets, name: str, caption: str) -> list[Table]:
    """What the sets of assets hold, by kind of handle; nothing if there are none."""
    lists = {
        "all assets": chosen.all_assets,
        "random assets": chosen.random_assets,
        "validation": chosen.validation_assets,
        "test": chosen.test_assets,
    }
    rows = []
    for title, assets in lists.items():
        if assets:
            kinds = Counter(asset.handle for asset in assets)
            lengths = sorted(100 * asset.handle_length for asset in assets)
            rows.append(
                Row(
                    [
                        Cell(title), Cell(str(len(assets))), Cell(str(len({asset.family for asset in assets}))),
                        Cell(", ".join(f"{kind} {count}" for kind, count in sorted(kinds.items()))),
                        Cell(f"{lengths[0]:.0f}-{lengths[-1]:.0f} cm"),
                    ]
                )
            )  # fmt: skip
    columns = ["Set", "Assets", "Families", "By kind of handle", "Length of handles"]
    notes = ["A family is on one side alone: trained on, held out, validation or test."]
    return [Table(name, caption, columns, rows, notes=notes)] if rows else []
