"""Matching: nearest categories by words, and which assets an object is compared with."""

from pathlib import Path

import pytest

from roomkin.stages.config.matching import MatchingConfig
from roomkin.stages.contracts import Library
from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.contracts.library import LibraryEntry
from roomkin.stages.contracts.objects import SceneObject
from roomkin.stages.matching.candidates import Candidates, find_candidates
from roomkin.stages.matching.text_encoders import find_nearest_categories, make_text_encoder
from roomkin.stages.matching.text_encoders.lexical import TextEncoder, split_words

LEXICAL = TextEncoder(MatchingConfig())
CATEGORIES = [
    *("bottom_cabinet", "wall_cabinet", "wardrobe", "chest_of_drawers", "fridge", "microwave", "table", "coffee_table"),
    *(
        "table_lamp",
        "floor_lamp",
        "bookshelf",
        "television",
        "picture",
        "plant_pot",
        "cooking_pot",
        "mug",
        "sofa",
        "box",
        "trash_can",
        "candlestick",
    ),
]


@pytest.mark.parametrize(
    ("label", "expected"),
    [
        ("fridge", "fridge"),
        ("Refrigerators", "fridge"),
        ("cup", "mug"),
        ("couch", "sofa"),
        ("tv", "television"),
        ("desk lamp", "table_lamp"),
        ("dining table", "table"),
        ("coffee-table", "coffee_table"),
        ("cupboards", "bottom_cabinet"),
        ("flower pot", "plant_pot"),
        ("book case", "bookshelf"),
        ("painting", "picture"),
        ("cardboard boxes", "box"),
        ("desk", "coffee_table"),  # no category of that name: kin
        ("nightstand", "bookshelf"),
        ("soup can", "mug"),  # a jar, of its kin a vessel: no trash can, no candlestick
        ("pitcher", "mug"),
    ],
)
def test_nearest_category(label: str, expected: str) -> None:
    assert find_nearest_categories(label, CATEGORIES, 3, LEXICAL)[0][0] == expected


LIBRARY_CATEGORIES = sorted(known_categories())


def test_a_further_name_of_several_words_means_its_category() -> None:
    for row in known_categories().values():
        for name in row.names:
            if " " in name:
                found = find_nearest_categories(f"old {name}", LIBRARY_CATEGORIES, 3, LEXICAL)
                assert found[0][0] == row.name, name
    assert find_nearest_categories("upper cabinet", ["bed", "bottom_cabinet"], 3, LEXICAL)[0][0] == "bottom_cabinet"


@pytest.mark.parametrize(
    ("label", "expected"),
    [
        *(("dresser", "chest_of_drawers"), ("bureau", "chest_of_drawers"), ("hutch", "bottom_cabinet")),
        *(
            ("stove", "oven"),
            ("sectional", "sofa"),
            ("trunk", "box"),
            ("tv set", "television"),
            ("chest", "chest_of_drawers"),
        ),
        *(("desk with drawers", "desk"), ("cabinet, white", "wall_cabinet"), ("table top", "table")),
        *(("pouf", "ottoman"), ("footstool", "ottoman"), ("couch cushion", "cushion"), ("pillow", "cushion")),
        *(("carpet", "rug"), ("door mat", "rug"), ("drapes", "curtain"), ("basin", "sink"), ("heater", "radiator")),
        *(("WC", "toilet"), ("washer", "washing_machine"), ("tumble dryer", "washing_machine")),
        *(("computer screen", "monitor"), ("desktop computer", "monitor"), ("computer mouse", "mouse")),
        *(("phone", "telephone"), ("table phone", "telephone"), ("cell phone", "cell_phone"), ("tv remote", "remote")),
        *(("tin", "can"), ("soup can", "can"), ("garbage can", "trash_can"), ("goblet", "wine_glass")),
        *(
            ("handbag", "bag"),
            ("backpack", "bag"),
            ("luggage", "suitcase"),
            ("fork", "cutlery"),
            ("teaspoon", "cutlery"),
        ),
        *(("desk keyboard", "keyboard"), ("screen", "monitor"), ("tv screen", "monitor")),
    ],
)
def test_words_of_households_are_understood(label: str, expected: str) -> None:
    assert find_nearest_categories(label, LIBRARY_CATEGORIES, 3, LEXICAL)[0][0] == expected
    assert LEXICAL.doubt(label, LIBRARY_CATEGORIES) == ""


@pytest.mark.parametrize(
    ("label", "first", "doubt"),
    [
        *((word, None, f"the word '{word}' is not known") for word in ("skateboard", "globe", "accordion", "door")),
        ("coffee maker", None, "the word 'maker' is not known"),  # no coffee table
        ("table globe", None, "the word 'globe' is not known"),  # no table
        ("whiteboard", "clock", "no category of the library is called 'whiteboard'"),  # flat, as a clock; no sideboard
        ("desk tablet", "clock", "no category of the library is called 'tablet'"),
        ("kitchen locker", "chest_of_drawers", "no category of the library is called 'locker'"),
        ("kitchen counter", "table", ""),
        ("Cabnet", "wall_cabinet", "the word 'cabnet' is not known: taken for 'cabinet'"),
        ("!?", None, "is no word"),
    ],
)  # fmt: skip
def test_letters_are_no_meaning_and_what_is_not_understood_is_doubted(
    label: str, first: str | None, doubt: str
) -> None:
    nearest = find_nearest_categories(label, LIBRARY_CATEGORIES, 1, LEXICAL)
    assert [name for name, _ in nearest] == ([] if first is None else [first])
    assert doubt in LEXICAL.doubt(label, LIBRARY_CATEGORIES)


@pytest.mark.parametrize(
    ("label", "expected"),
    [
        *(("rocker", "chair"), ("wing chair", "armchair"), ("four-poster", "bed"), ("escritoire", "desk")),
        *(("highboys", "chest_of_drawers"), ("credenza", "sideboard"), ("old coffee pot", "kettle"), ("wok", "pan")),
        *(("water glass", "mug"), ("stockpot", "cooking_pot"), ("microwave oven", "microwave"), ("pail", "trash_can")),
        *(("attache case", "suitcase"), ("portrait", "picture"), ("wristwatch", "clock"), ("hob", "oven")),
    ],
)
def test_wordnet_says_what_other_words_mean(label: str, expected: str) -> None:
    assert find_nearest_categories(label, LIBRARY_CATEGORIES, 3, LEXICAL)[0][0] == expected
    assert LEXICAL.doubt(label, LIBRARY_CATEGORIES) == ""


def test_a_word_of_the_library_is_not_explained() -> None:
    assert [name for name, _ in find_nearest_categories("wok", ["pan", "wok"], 1, LEXICAL)] == ["wok"]
    assert [name for name, _ in find_nearest_categories("wok", ["pan", "plate"], 1, LEXICAL)] == ["pan"]


def test_a_category_of_ones_own_is_known() -> None:
    assert LEXICAL.doubt("espresso machine", ["espresso_machine", "table"]) == ""
    assert [name for name, _ in find_nearest_categories("globe", ["globe", "wardrobe"], 2, LEXICAL)] == ["globe"]


def test_labels_of_our_rooms_are_understood() -> None:
    rooms = (Path(__file__).parents[2] / "plugins/scenes/rooms").glob("*.yaml")
    labels = {
        line.split("label:")[1].strip(" }")
        for room in rooms
        for line in room.read_text().splitlines()
        if "label:" in line
    }
    assert len(labels) > 25 and {label: LEXICAL.doubt(label, LIBRARY_CATEGORIES) for label in labels} == dict.fromkeys(
        labels, ""
    )


def test_an_exact_name_has_distance_zero_and_nothing_in_common_is_left_out() -> None:
    assert find_nearest_categories("television", CATEGORIES, 3, LEXICAL) == [("television", 0.0), ("picture", 0.75)]
    assert find_nearest_categories("xyzzy", CATEGORIES, 3, LEXICAL) == []
    assert find_nearest_categories("", CATEGORIES, 3, LEXICAL) == []
    assert find_nearest_categories("table", [], 3, LEXICAL) == []


@pytest.mark.parametrize(
    ("label", "categories", "expected"),
    [("table lamp", ["table", "floor_lamp"], "floor_lamp"), ("book shelf stand", ["book", "stand"], "stand")],
)
def test_the_last_word_says_what_a_thing_is(label: str, categories: list[str], expected: str) -> None:
    assert find_nearest_categories(label, categories, 1, LEXICAL)[0][0] == expected


def test_distances_do_not_depend_on_the_order_of_categories() -> None:
    forward = find_nearest_categories("wall cabinet", CATEGORIES, 5, LEXICAL)
    assert forward == find_nearest_categories("wall cabinet", CATEGORIES[::-1], 5, LEXICAL)
    assert split_words("Wall_Cabinets") == ["wall", "cabinet"]
    assert split_words("glass vases") == ["glass", "vase"]


def entry(id: str, doors: int = 0, drawers: int = 0) -> LibraryEntry:
    category = id.rsplit("_", 1)[0]
    return LibraryEntry(id=id, category=category, archive="shard_0.zip", doors=doors, drawers=drawers, checksum="")


LIBRARY = Library(
    assets=[entry("cabinet_0", 2), entry("cabinet_1", 1, 3), entry("cabinet_2"), entry("fridge_0", 2), entry("table_0")]
)


def found(item: dict, **options: object) -> Candidates:
    base = {"id": "x_1", "label": "cabinet", "mask": 1}
    text_distance = make_text_encoder(MatchingConfig())
    settings = MatchingConfig.model_validate({"least_candidates": 1} | options)
    return find_candidates(SceneObject.model_validate(base | item), LIBRARY, text_distance, settings)


def names(candidates: Candidates) -> list[str]:
    return [asset.id for asset in candidates.assets]


def test_articulated_objects_are_sought_among_articulated_assets() -> None:
    two_doors = {"articulated": True, "doors": 2}
    assert names(found({})) == ["cabinet_0", "cabinet_1", "cabinet_2"]
    assert names(found(two_doors, count_threshold=None)) == ["cabinet_0", "cabinet_1"]
    assert names(found(two_doors)) == ["cabinet_0"]  # |2 - 1| + |0 - 3| = 4 > 2
    assert names(found(two_doors, count_threshold=3)) == ["cabinet_0"]
    assert names(found(two_doors, count_threshold=4)) == ["cabinet_0", "cabinet_1"]
    assert found(two_doors).note == ""


def test_a_threshold_without_candidates_is_widened_visibly_but_never_to_assets_without_joints() -> None:
    many = found({"articulated": True, "doors": 0, "drawers": 7}, count_threshold=1)
    assert names(many) == ["cabinet_1"] and many.note == "count_threshold widened from 1 to 5"
    table = found({"label": "table", "articulated": True, "drawers": 1})
    assert "table_0" not in names(table) and "no category of the library is called 'table'" in table.doubt


def test_a_word_in_doubt_says_what_is_nearest() -> None:
    mixer = found({"label": "washer"})
    assert mixer.doubt.endswith("called 'washer': taken by its kind, picture and size; nearest: fridge")


def test_candidates_that_are_too_few_grow_by_counts_and_by_categories_in_order() -> None:
    two_doors = {"articulated": True, "doors": 2, "drawers": 0}
    more = found(two_doors, least_candidates=2, k_cat=1)
    assert names(more) == ["cabinet_0", "cabinet_1"] and more.note == "count_threshold widened from 2 to 4"
    plain = found({"label": "table cabinet"}, least_candidates=4, k_cat=1)
    assert [match.category for match in plain.categories] == ["cabinet", "table"]
    assert names(plain) == ["cabinet_0", "cabinet_1", "cabinet_2", "table_0"]
    assert plain.note == "categories widened from 1 to 2"
    assert "table_0" not in names(found(two_doors, least_candidates=10))


def test_unknown_label_searches_everything_and_says_so() -> None:
    result = found({"label": "xyzzy"})
    assert len(result.assets) == len(LIBRARY.assets) and result.categories == []
    assert result.doubt == "the word 'xyzzy' is not known: taken by picture and size alone" and result.note == ""
