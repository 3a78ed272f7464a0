"""Command `learn`: draw shapes from random rooms of our own models, and train the network that names them."""

from pathlib import Path

from safetensors.torch import save
from torch import set_num_threads

from plugins.names.network import ShapeNetwork
from plugins.names.propose import NETWORK
from plugins.names.training.draw import draw_examples, list_names
from plugins.names.training.optimise import Options, train
from stages.contracts.files import write_atomically


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
    """
    set_num_threads(1)
    names = list_names()
    examples = draw_examples(rooms, models, seed, processes)
    print(f"{len(examples.name)} shapes of {len(names)} names", flush=True)
    write_network(out, train(examples, len(names), seed, Options(epochs=epochs), device), names)
