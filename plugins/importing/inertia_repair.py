"""Repair masses and inertias that no model of this size has: placeholders of exporters become those of boards."""

from dataclasses import replace

import numpy as np

from roomkin.stages.articulated.attributes import list_moved_links
from roomkin.stages.articulated.forward_kinematics import measure_closed_box
from roomkin.stages.articulated.model import Link, RobotModel
from roomkin.stages.geometry.solids import board_mass, box_inertia

HEAVY = 5.0  # times what boards weigh: a door is no solid block, and the water in its hull is ten times as heavy
LIGHTEST, HEAVIEST = 1 / 15, 20.0  # times what boards weigh, of a whole thing: thin sheets, and solid stone or steel
SPARSEST = 4.0  # kg per cubic metre of its box: a chair has fifteen
ROOM = 4.0  # metres: no thing in a room is as wide and as deep
SLACK = 0.01  # by which a principal moment of inertia may exceed the sum of the others


def repair_inertias(robot: RobotModel) -> tuple[RobotModel, list[str]]:
    """The model (in metres) with masses of doors and drawers, and inertias, that its shape can have; lines say what was
    changed, and what is doubtful about the whole."""
    lines, links = _doubts(robot), dict(robot.links)
    for joint in robot.joints:
        if joint.type == "fixed":
            continue
        moving = {name: links[name] for name in list_moved_links(joint, robot.joints)}
        boards = {name: _boards(link) for name, link in moving.items()}
        given, expected = sum(link.mass for link in moving.values()), sum(boards.values())
        if given > HEAVY * expected:
            lines.append(
                f"what '{joint.name}' moves weighs {given:.3g} kg in its file: taken for boards, {expected:.2g} kg"
            )
            links |= {name: _set_mass(link, boards[name]) for name, link in moving.items()}
    impossible = [name for name, link in links.items() if _is_impossible(link)]
    for name in impossible:
        links[name] = replace(links[name], inertia=box_inertia(links[name].collisions, links[name].mass))
    if impossible:
        names = ", ".join(f"'{name}'" for name in impossible)
        lines.append(f"inertia of {names} taken for that of a box: nothing has the one in its file")
    return replace(robot, links=links), lines


def _doubts(robot: RobotModel) -> list[str]:
    """Lines if it is as large as a room, or if its file says that it weighs what nothing of its size does."""
    extents = np.ptp(measure_closed_box(robot), axis=0)
    shorter, longer = np.sort(extents[:2])
    lines = [f"is {shorter:.2g} by {longer:.2g} m: a whole room is no model (one file a thing)"] * bool(shorter > ROOM)
    weighed = [link for link in robot.links.values() if link.weighed]
    mass, boards = sum(link.mass for link in weighed), sum(_boards(link) for link in weighed)
    if weighed and not LIGHTEST * boards <= mass <= HEAVIEST * boards:
        lines.append(f"weighs {mass:.3g} kg in its file, boards of its size {boards:.3g} kg (asset.json: mass)")
    elif robot.mass < SPARSEST * np.prod(extents):
        lines.append(f"weighs {robot.mass:.3g} kg, less than anything of its size (asset.json: mass)")
    return lines


def _boards(link: Link) -> float:
    return board_mass(link.collisions, link.visuals)


def _set_mass(link: Link, mass: float) -> Link:
    return replace(link, mass=mass, inertia=link.inertia * (mass / link.mass), weighed=False)


def _is_impossible(link: Link) -> bool:
    """Whether nothing has such an inertia: two principal moments are together at least as large as the third."""
    least, middle, most = np.linalg.eigvalsh(link.inertia)
    return bool(most > (1 + SLACK) * (least + middle))


def with_mass(robot: RobotModel, mass: float) -> RobotModel:
    """The model with another total mass, spread as before."""
    ratio = mass / robot.mass
    links = {n: replace(link, mass=link.mass * ratio, inertia=link.inertia * ratio) for n, link in robot.links.items()}
    return replace(robot, links=links)
