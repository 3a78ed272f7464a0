"""The assets of a policy experiment: their roles, their handles, and which of them are in the demonstrations."""

from collections import Counter
from collections.abc import Iterable

from roomkin.stages.contracts.policies import TaskAsset, TaskAssets
from roomkin.stages.contracts.policy_config import DRAW, DRAWN, RANDOMISED, SetName, is_set, read_set, strip_randomised
from roomkin.stages.tables.rows import title
from roomkin.stages.tables.text import TextTable, cell, number, read_notes


def role_title(role: str) -> str:
    """The title of a role. The role random_3 is one asset, the set three; random_19 is the third of draw 2."""
    rule, place, randomised = read_set(role) if is_set(role) else SetName(role, 1, False)
    if rule not in DRAWN:
        return title(role)
    draw, place = divmod(place - 1, DRAW)
    return f"{rule} {place + 1}" + f" of draw {draw + 1}" * (draw > 0) + ", randomised" * randomised


def handle_kind(asset: TaskAsset) -> str:
    """Handle and hinge: 'bar, hinge left'; 'knob, slide'."""
    return f"{asset.handle}, {'slide' if asset.hinge == 'slide' else f'hinge {asset.hinge}'}"


def by_role(chosen: TaskAssets) -> dict[str, TaskAsset]:
    """Role -> asset; those that were drawn are random_1, ..., cover_1, ..., as in demonstrations."""
    return {asset.role: asset for asset in chosen.assets} | chosen.drawn_roles()


def used_roles(chosen: TaskAssets, demonstrated: Iterable[str]) -> dict[str, TaskAsset]:
    """`by_role` without drawn assets that have no demonstrations."""
    used = set(map(strip_randomised, demonstrated))
    return {role: asset for role, asset in by_role(chosen).items() if role in used or role not in chosen.drawn_roles()}


def list_demonstrated_assets(chosen: TaskAssets, roles: Iterable[str]) -> list[TaskAsset]:
    """The assets on which the demonstrations of some roles are collected, randomised or not."""
    known, names = by_role(chosen), list(dict.fromkeys(map(strip_randomised, roles)))
    return [*(known[name] for name in names if name in known), *(chosen.all_assets if "all" in names else [])]


def roles_table(chosen: TaskAssets, demonstrated: Iterable[str], name: str, caption: str) -> TextTable:
    """A row per role; `demonstrated`: roles on which demonstrations are collected, `all` for all of `all_assets`."""
    roles = set(demonstrated)
    handles = {handle_kind(asset) for asset in list_demonstrated_assets(chosen, roles)}
    in_all = {asset.asset for asset in chosen.all_assets} if "all" in map(strip_randomised, roles) else set()
    rows = []
    for role, asset in used_roles(chosen, roles).items():
        length = f"{100 * asset.handle_length:.0f} cm, at {100 * asset.handle_height:.0f} % of the front"
        panel = " x ".join(f"{side:.2f}" for side in asset.panel_size)
        used = ["yes"] if role in roles else ["in all assets"] if asset.asset in in_all else []
        used += ["randomised"] if role + RANDOMISED in roles else []
        rows.append(
            [
                role_title(role), asset.asset, asset.family, number(asset.distance, 2),
                cell(handle_kind(asset), length), cell(f"{asset.panel_height:.2f} m", f"{panel} m"),
                ", ".join(used) or "no", "yes" if handle_kind(asset) in handles else "no",
            ]
        )  # fmt: skip
    return TextTable(
        name=name,
        caption=caption,
        columns=["Role", "Model", "Family", "Distance", "Handle", "Panel", "Demonstrated", "Handle known"],
        rows=rows,
        notes=read_notes("roles", "roomkin.plugins.report"),
    )


def lists_table(chosen: TaskAssets, name: str, caption: str) -> list[TextTable]:
    """The sets of assets by kind of handle; nothing if there are none."""
    lists = {
        "all assets": chosen.all_assets,
        "random assets": chosen.random_assets,
        "covering assets": chosen.cover_assets,
        "validation": chosen.validation_assets,
        "test": chosen.test_assets,
    }
    rows = []
    for heading, listed in lists.items():
        if assets := list({asset.asset: asset for asset in listed}.values()):
            kinds = ", ".join(f"{kind} {n}" for kind, n in sorted(Counter(asset.handle for asset in assets).items()))
            lengths = sorted(100 * asset.handle_length for asset in assets)
            families = len({asset.family for asset in assets})
            rows.append([heading, str(len(assets)), str(families), kinds, f"{lengths[0]:.0f}-{lengths[-1]:.0f} cm"])
    columns = ["Set", "Assets", "Families", "By kind of handle", "Length of handles"]
    notes = read_notes("lists", "roomkin.plugins.report")
    return [TextTable(name, caption, columns, rows, notes=notes)] if rows else []
