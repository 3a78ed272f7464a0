"""Masses and inertias that nothing of such a size has: what exporters fill in becomes that of boards."""

from dataclasses import replace

import numpy as np

from stages.articulated.attributes import moved_by
from stages.articulated.model import Link, RobotModel
from stages.articulated.urdf_reader import board_mass, box_around, box_inertia

ODD = 20.0  # times as heavy or as light as boards: solid steel is 16 times as heavy as wood
ROD = 1e-5  # least principal moment of inertia, of the largest: a thinner rod's is nothing once it is rounded
SLACK = 0.01  # by which a principal moment of inertia may exceed the sum of the others
HEAVY = 5.0  # the same of a door or drawer, which is no solid block: water in its hull is ten times as heavy


def weighed_sanely(robot: RobotModel) -> tuple[RobotModel, list[str]]:
    """The model (in metres) with masses and inertias that its shape can have; lines say what was changed."""
    told, boards = robot.mass, {name: _boards(link) for name, link in robot.links.items()}
    expected, lines, links = sum(boards.values()), [], dict(robot.links)
    if any(link.weighed for link in links.values()) and not expected / ODD <= told <= expected * ODD:
        lines.append(f"weighs {told:.3g} kg in its file, unlike anything of its size: taken for boards")
        links = {name: _of_boards(link, boards[name]) for name, link in links.items()}
    for joint in robot.joints:
        if joint.type == "fixed":
            continue
        moving = moved_by(joint, robot.joints)
        told, expected = (sum(masses) for masses in ([links[n].mass for n in moving], [boards[n] for n in moving]))
        if told > HEAVY * expected:
            lines.append(
                f"what '{joint.name}' moves weighs {told:.3g} kg in its file: taken for boards, {expected:.2g} kg"
            )
            links |= {name: _of_boards(links[name], boards[name]) for name in moving}
    impossible = [name for name, link in links.items() if _impossible(link)]
    for name in impossible:
        links[name] = replace(links[name], inertia=box_inertia(links[name].collisions, links[name].mass))
    if impossible:
        names = ", ".join(f"'{name}'" for name in impossible)
        lines.append(f"inertia of {names} taken for that of a box: none of that mass and size has the one in its file")
    return replace(robot, links=links), lines


def _of_boards(link: Link, mass: float) -> Link:
    inertia = box_inertia(link.collisions, mass) if _impossible(link) else link.inertia * (mass / link.mass)
    return replace(link, mass=mass, inertia=inertia, weighed=False)


def _boards(link: Link) -> float:
    return board_mass(link.collisions, link.visuals)


def _impossible(link: Link) -> bool:
    """Whether nothing has such an inertia, or only a larger thing: mass would have to lie outside of the link."""
    least, middle, most = np.linalg.eigvalsh(link.inertia)
    if most > (1 + SLACK) * (least + middle) or least < ROD * most:
        return True
    shapes = [*link.collisions, *(visual.mesh for visual in link.visuals)]
    farthest = float(np.linalg.norm(np.ptp(box_around(shapes), axis=0)))
    return bool(np.trace(link.inertia) > link.mass * (2 * farthest) ** 2)


def with_mass(robot: RobotModel, mass: float) -> RobotModel:
    """The model with another total mass, spread as before."""
    ratio = mass / robot.mass
    links = {n: replace(link, mass=link.mass * ratio, inertia=link.inertia * ratio) for n, link in robot.links.items()}
    return replace(robot, links=links)
