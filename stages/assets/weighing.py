"""Masses and inertias that nothing of such a size has: what exporters fill in becomes that of boards."""

from dataclasses import replace

import numpy as np

from stages.articulated.model import Link, RobotModel
from stages.articulated.urdf_reader import board_mass, box_around, box_inertia

ODD = 20.0  # times as heavy or as light as boards: solid steel is 16 times as heavy as wood


def weighed_sanely(robot: RobotModel) -> tuple[RobotModel, list[str]]:
    """The model (in metres) with masses and inertias that its shape can have; lines say what was changed."""
    told, boards = robot.mass, {name: _boards(link) for name, link in robot.links.items()}
    expected, lines, links = sum(boards.values()), [], dict(robot.links)
    if any(link.weighed for link in links.values()) and not expected / ODD <= told <= expected * ODD:
        lines.append(f"weighs {told:.3g} kg in its file, unlike anything of its size: taken for boards")
        for name, link in links.items():
            ratio = boards[name] / link.mass
            inertia = box_inertia(link.collisions, boards[name]) if _impossible(link) else link.inertia * ratio
            links[name] = replace(link, mass=boards[name], inertia=inertia, weighed=False)
    impossible = [name for name, link in links.items() if _impossible(link)]
    for name in impossible:
        links[name] = replace(links[name], inertia=box_inertia(links[name].collisions, links[name].mass))
    if impossible:
        names = ", ".join(f"'{name}'" for name in impossible)
        lines.append(f"inertia of {names} taken for that of a box: none of that mass and size has the one in its file")
    return replace(robot, links=links), lines


def _boards(link: Link) -> float:
    return board_mass(link.collisions, link.visuals)


def _impossible(link: Link) -> bool:
    """Whether the inertia is that of a larger thing: mass would have to lie outside of the link."""
    shapes = [*link.collisions, *(visual.mesh for visual in link.visuals)]
    farthest = float(np.linalg.norm(np.ptp(box_around(shapes), axis=0)))
    return bool(np.trace(link.inertia) > link.mass * (2 * farthest) ** 2)
