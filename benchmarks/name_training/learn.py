"""Command `learn`: draw shapes from random rooms of our own models, and train the network that names them.

Examples of shapes with their names, from random rooms of our own models, by several processes.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from safetensors.torch import save
from torch import Tensor, set_num_threads
from torch.nn import functional

from benchmarks.name_training.dirt import OTHER, SAME, Mask, cut_patch, share_owner, soil
from benchmarks.name_training.pictures import BACKGROUND, NOTHING, TrainingPicture, pictures_in, sense_depth, tilt_frame
from benchmarks.name_training.rooms import MadeRoom, furnish, make_pool
from benchmarks.name_training.solids import Rng
from roomkin.plugins.furniture.catalogue import CATEGORIES
from roomkin.stages.contracts.files import write_atomically
from roomkin.stages.geometry.frames import back_project, transform_points
from roomkin.stages.perception.classification.network import NUMBERS, ShapeNetwork
from roomkin.stages.perception.classification.propose import AROUND, FAR, NETWORK, POINTS, ShapeInput, measure_shape

MIN_PIXELS = 60  # pixels of a mask in a picture of 320 x 240
VIEWS = 7  # of a room
PATCHES = 1  # of no thing, in a picture
NONE = "other"
AS_IF = {"office_chair": "chair"}  # a kind of the rooms that the library lacks


class Examples(NamedTuple):
    """points (N, POINTS, 3), around (N, AROUND, 3) float16, numbers (N, 8) float32; name (N,) of `list_names`."""

    points: NDArray[np.float16]
    around: NDArray[np.float16]
    numbers: NDArray[np.float32]
    name: NDArray[np.int64]


def list_names() -> list[str]:
    """The categories of the library, sorted, and last: none of them."""
    return [*sorted(CATEGORIES), NONE]


def name_kind(kind: str) -> str:
    """The name of a kind of the rooms."""
    name = AS_IF.get(kind, kind)
    return name if name in CATEGORIES else NONE


def draw_examples(rooms: int, models: int, seed: int, processes: int = 1, packs: Path | None = None) -> Examples:
    """Things of so many rooms that are furnished with so many models of a kind; the same by any number of processes.

    packs: other people's models beside, see `make_pool`.
    """
    draw = partial(draw_room, models, seed, packs)
    if processes == 1:
        drawn = [draw(number) for number in range(rooms)]
    else:
        with get_context("spawn").Pool(processes) as pool:
            drawn = pool.map(draw, range(rooms), chunksize=4)
    return Examples(*(np.concatenate(each) for each in zip(*drawn, strict=True)))


def draw_room(models: int, seed: int, packs: Path | None, number: int) -> Examples:
    """The examples of a room."""
    rng, names = np.random.default_rng((seed, number)), list_names()
    room = furnish(make_pool(models, seed, packs), rng)
    found = [one for picture in pictures_in(room, VIEWS, rng) for one in look_at(picture, room, rng)]
    return Examples(
        np.array([shape.points for _, shape in found], np.float16).reshape(-1, POINTS, 3),
        np.array([shape.around for _, shape in found], np.float16).reshape(-1, AROUND, 3),
        np.array([shape.numbers for _, shape in found], np.float32).reshape(-1, NUMBERS),
        np.array([names.index(name) for name, _ in found], np.int64),
    )


def look_at(picture: TrainingPicture, room: MadeRoom, rng: Rng) -> Iterator[tuple[str, ShapeInput]]:
    """The masks of a picture that show a thing or none, with the name, as a sensor sees them."""
    depth, frame = sense_depth(picture, rng), tilt_frame(picture.frame, rng)
    points, known = transform_points(frame, back_project(depth, picture.intrinsics)), depth > 0
    wholes = find_wholes(picture, room)
    masks = [soil(some[-1 if rng.random() < 0.3 else 0], picture.owner, rng) for some in wholes.values()]
    masks += [cut_patch(picture.owner <= BACKGROUND, rng) for _ in range(PATCHES)]
    for mask in masks:
        number, iou = share_owner(mask, wholes)
        shape = measure_shape(points, known, mask, float(frame[2, 3])) if mask.sum() >= MIN_PIXELS else None
        if shape is not None and not OTHER < iou < SAME:
            yield (name_kind(room.things[number - 2].solid.kind) if iou >= SAME else NONE), shape


def find_wholes(picture: TrainingPicture, room: MadeRoom) -> dict[int, list[Mask]]:
    """By its number what shows a thing: its pixels, and these with those of what it carries."""
    seen = [int(one) for one in np.unique(picture.owner) if BACKGROUND < one < NOTHING]
    wholes = {}
    for number in seen:
        alone = picture.owner == number
        carried = [one for one in seen if room.things[one - 2].support == number]
        wholes[number] = [alone, alone | np.isin(picture.owner, carried)] if carried else [alone]
    return wholes


STRETCH, STRETCH_SIDE, TURN, JITTER, RAISE = 0.08, 0.06, 0.15, 0.004, 0.015  # log, log, radians, metres, metres; chosen
SMOOTHING = 0.05  # of labels; chosen


@dataclass(frozen=True)
class Options:
    """epochs over the examples; examples of an update; AdamW's peak rate, which rises and falls (one cycle)."""

    epochs: int = 20
    batch: int = 512
    learning_rate: float = 2e-3
    weight_decay: float = 1e-2


def train(examples: Examples, names: int, seed: int, options: Options, device: str) -> ShapeNetwork:
    """The network after so many epochs, on the CPU; one thread of it gives the same weights every time."""
    torch.manual_seed(seed)
    data = [torch.from_numpy(each).to(device) for each in examples]
    network = ShapeNetwork(names).to(device)
    # Logits are of names that are all as likely before (logit adjustment, Menon et al. 2021).
    common = (torch.bincount(data[3], minlength=names) + 1.0).log()
    optimiser = torch.optim.AdamW(network.parameters(), options.learning_rate, weight_decay=options.weight_decay)
    steps = max(1, len(data[3]) // options.batch)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, options.learning_rate, steps * options.epochs + 1)
    for epoch in range(options.epochs):
        total = torch.zeros((), device=device)
        for some in torch.randperm(len(data[3]), device=device).split(options.batch)[:steps]:
            points, around, numbers, name = (each[some] for each in data)
            logits = network(*vary(points.float(), around.float(), numbers))
            loss = functional.cross_entropy(logits + common, name, label_smoothing=SMOOTHING)
            optimiser.zero_grad()
            loss.backward()
            torch.nn.utils.clip_grad_norm_(network.parameters(), 1.0)
            optimiser.step()
            schedule.step()
            total += loss.detach()
        print(f"epoch {epoch + 1}: loss {float(total) / steps:.3f}", flush=True)
    return network.cpu().eval()


def vary(points: Tensor, around: Tensor, numbers: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """Shapes stretched as a whole and along each side, turned a little, half of them mirrored, raised, jittered."""
    sides, middle = points[:, :1], points[:, 0, 0]
    scale = torch.exp(STRETCH * torch.randn_like(sides[..., :1]) + STRETCH_SIDE * torch.randn_like(sides))
    angle = TURN * torch.randn_like(middle)
    c, s, nil, one = angle.cos(), angle.sin(), torch.zeros_like(angle), torch.ones_like(angle)
    turn = torch.stack([c, -s, nil, s, c, nil, nil, nil, one], dim=-1).view(-1, 3, 3)
    flip, up = torch.ones_like(sides), torch.zeros_like(sides)
    flip[:, 0, 1] = torch.where(torch.rand_like(middle) < 0.5, -1.0, 1.0)
    up[:, 0, 2] = RAISE * torch.randn_like(middle)
    moved = [(each @ turn.transpose(1, 2)) * scale * flip + up for each in (points, around)]
    numbers = numbers.clone()
    mirrored = flip[:, 0, 1] < 0
    numbers[mirrored, 4:6] = numbers[mirrored, 4:6].flip(1)  # left and right
    around = torch.where(around == FAR, around, moved[1])
    return moved[0] + JITTER * torch.randn_like(points), around, numbers


def write_network(out: Path, network: ShapeNetwork, names: list[str]) -> None:
    """The weights as fp16 safetensors, the names of the outputs beside them."""
    weights = {name: value.half().contiguous() for name, value in sorted(network.state_dict().items())}
    with write_atomically(out) as temporary:
        temporary.write_bytes(save(weights, {"names": " ".join(names)}))


def run(
    *,
    out: Path = NETWORK,
    rooms: int = 4581,
    models: int = 24,
    epochs: int = 20,
    seed: int = 1,
    processes: int = 1,
    device: str = "cpu",
    packs: Path | None = None,
) -> None:
    """Write the network. On the CPU the same numbers write the same bytes, by however many processes rooms are drawn.

    Args:
        out: the file.
        rooms: about forty shapes are drawn from each.
        models: of a category.
        epochs: times that every shape is learnt from.
        seed: of models, rooms and initial weights.
        processes: that draw.
        device: of PyTorch, that trains: cpu or cuda.
        packs: folder of `benchmarks.open_rooms fetch`: models of the half `work` stand in the rooms, too.
    """
    set_num_threads(1)
    names = list_names()
    examples = draw_examples(rooms, models, seed, processes, packs)
    print(f"{len(examples.name)} shapes of {len(names)} names", flush=True)
    write_network(out, train(examples, len(names), seed, Options(epochs=epochs), device), names)
