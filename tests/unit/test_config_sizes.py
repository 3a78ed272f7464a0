"""What is left to the size of the library."""

from roomkin.stages.config.commands import fill_counts
from roomkin.stages.config.model import Config, load


def test_a_small_library_is_exact_and_a_large_one_compressed_and_shortlisted() -> None:
    small, large = fill_counts(Config(), 495), fill_counts(Config(), 2_001)
    assert (small.matching.dimensions, small.matching.shortlist) == (0, 0)
    assert (large.matching.dimensions, large.matching.shortlist) == (72, 100)
    assert (
        small.matching_of("default").store()
        == Config().matching_of("default").store()
        != large.matching_of("default").store()
    )


def test_shards_hold_some_three_hundred_models() -> None:
    def shards(models: int) -> int | None:
        assets = Config().assets.model_copy(update={"counts": {"mug": models}})
        return fill_counts(Config().model_copy(update={"assets": assets}), models).assets.shards

    assert [shards(models) for models in (0, 600, 601, 9_900)] == [2, 2, 3, 33]


def test_what_is_set_is_kept() -> None:
    given = load({"assets": {"shards": 5}, "matching": {"dimensions": 0, "shortlist": 60}})
    kept = fill_counts(given, 10_000)
    assert (kept.assets.shards, kept.matching.dimensions, kept.matching.shortlist) == (5, 0, 60)
