"""What there is: generators by name (a recipe calls one) and, per category, how its members are drawn."""

import zlib
from collections.abc import Callable

import numpy as np

from stages.contracts.library import Recipe
from stages.procedural import (
    cabinet_draws,
    decor,
    families,
    lamps,
    plants,
    seats,
    sofas,
    storage,
    tables_and_beds,
    turned,
    vessels,
)
from stages.procedural.cabinet import cabinet
from stages.procedural.model import Draw, Generator

GENERATORS: dict[str, Generator] = {
    "bed": tables_and_beds.bed,
    "book": storage.book,
    "bookshelf": storage.bookshelf,
    "bowl": vessels.bowl,
    "cabinet": cabinet,
    "carton": storage.carton,
    "chair": seats.chair,
    "cooking_pot": vessels.cooking_pot,
    "lamp": lamps.lamp,
    "mug": vessels.mug,
    "picture": decor.picture,
    "plant_pot": plants.plant_pot,
    "plate": vessels.plate,
    "sofa": sofas.sofa,
    "stool": seats.stool,
    "table": tables_and_beds.table,
    "television": decor.television,
    "turned_vessel": turned.turned_vessel,
}

CATEGORIES: dict[str, Callable[[np.random.Generator, int], Draw]] = {
    "bed": tables_and_beds.draw_bed,
    "book": storage.draw_book,
    "bookshelf": storage.draw_bookshelf,
    "bottle": turned.draw_bottle,
    "bottom_cabinet": cabinet_draws.bottom_cabinet,
    "bowl": vessels.draw_bowl,
    "box": storage.draw_box,
    "chair": seats.draw_chair,
    "chest_of_drawers": cabinet_draws.chest_of_drawers,
    "coffee_table": tables_and_beds.draw_coffee_table,
    "cooking_pot": vessels.draw_cooking_pot,
    "dishwasher": cabinet_draws.dishwasher,
    "floor_lamp": lamps.draw_floor_lamp,
    "fridge": cabinet_draws.fridge,
    "microwave": cabinet_draws.microwave,
    "mug": vessels.draw_mug,
    "oven": cabinet_draws.oven,
    "picture": decor.draw_picture,
    "plant_pot": plants.draw_plant_pot,
    "plate": vessels.draw_plate,
    "sideboard": cabinet_draws.sideboard,
    "sofa": sofas.draw_sofa,
    "stool": seats.draw_stool,
    "table": tables_and_beds.draw_table,
    "table_lamp": lamps.draw_table_lamp,
    "television": decor.draw_television,
    "vase": turned.draw_vase,
    "wall_cabinet": cabinet_draws.wall_cabinet,
    "wardrobe": cabinet_draws.wardrobe,
}


def sample(category: str, index: int, seed: int) -> Recipe:
    """The recipe of the `index`-th model of a category; it does not depend on how many others there are."""
    founder = families.founder_of(category, index)
    if founder is None:
        draw = CATEGORIES[category](_generator(category, index, seed), index)
        return Recipe(generator=draw.generator, parameters={"size": list(draw.size), **draw.parameters})
    first = CATEGORIES[category](_generator(category, founder, seed), founder)
    generation = index // families.FOUNDERS[category]
    draw = families.relative(category, first, generation, _generator(category, index, seed))
    return Recipe(
        generator=draw.generator,
        parameters={"size": list(draw.size), **draw.parameters},
        variation_of=model_name(category, founder),
    )


def model_name(category: str, index: int) -> str:
    """Id of the `index`-th model of a category."""
    return f"{category}_{index:02d}"


def _generator(category: str, index: int, seed: int) -> np.random.Generator:
    return np.random.default_rng(np.random.SeedSequence((seed, zlib.crc32(category.encode()), index)))
