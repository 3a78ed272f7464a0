"""Matching: compressed feature rows, and the shortlist by views as wholes."""

from pathlib import Path

import numpy as np
import pytest

from roomkin.stages.config.matching import MatchingConfig
from roomkin.stages.contracts import Library, read_json
from roomkin.stages.contracts.cousins import CategoryMatch
from roomkin.stages.contracts.features import check_features
from roomkin.stages.contracts.objects import SceneObject
from roomkin.stages.geometry.frames import look_at
from roomkin.stages.matching.candidates import Candidates
from roomkin.stages.matching.encoders import EXTRA_COLUMNS, make_encoder, settings_digest
from roomkin.stages.matching.ranking import make_query, shortlist
from roomkin.stages.matching.snapshots import SnapshotFile, up_of_camera
from roomkin.stages.matching.store import FeatureStore, Snapshot, learn
from tests.refusals import refused
from tests.unit.matching_data import MODELS, World


@pytest.fixture(scope="module")
def exact(tmp_path_factory: pytest.TempPathFactory) -> World:
    return World(tmp_path_factory.mktemp("exact"))


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> World:
    return World(tmp_path_factory.mktemp("small"), dimensions=40)


def opened(world: World) -> FeatureStore:
    options = MatchingConfig.model_validate(world.options)
    return FeatureStore(world.features, settings_digest(options, make_encoder(options)))


def test_a_codec_keeps_what_varies_and_the_last_columns() -> None:
    rng = np.random.default_rng(0)
    plane = rng.normal(size=(2, 30))
    rows = np.concatenate([rng.uniform(-1, 1, (500, 2)) @ plane, rng.uniform(-1, 1, (500, 3))], axis=1)
    codec = learn(rows[::2], 2, kept=3)
    codes = codec.encode(rows)
    assert codes.shape == (500, 5) and codes.dtype == np.int8
    assert np.abs(codec.decode(codes) - rows).max() < 0.1
    assert np.abs(codec.decode(codes) - rows)[:, -3:].max() < 0.005
    coarse = learn(rows[::2], 1, kept=3)
    assert np.abs(coarse.decode(coarse.encode(rows)) - rows).max() > 0.5


def test_compressed_rows_are_small_and_near(exact: World, small: World) -> None:
    a, b = opened(exact), opened(small)
    for path in small.features:
        check_features(path)
        exactly = path.parents[2] / exact.folder.name / "features" / path.name
        assert 6 * path.stat().st_size < exactly.stat().st_size
    for name in MODELS:
        one, other = (store.rows(Snapshot(name, 3)).astype(np.float32) for store in (a, b))
        assert one.shape == other.shape
        assert np.linalg.norm(one - other, axis=1).mean() < 0.35 * np.linalg.norm(one - one.mean(0), axis=1).mean()
        assert np.abs(one - other)[:, -EXTRA_COLUMNS:].max() < 0.03


def test_same_bytes_again(small: World, tmp_path: Path) -> None:
    again = World(tmp_path, dimensions=40)
    for one, other in zip(small.features, again.features, strict=True):
        for suffix in (".npy", ".npz"):
            assert one.with_suffix(suffix).read_bytes() == other.with_suffix(suffix).read_bytes()


def test_compressed_features_give_nearly_the_same_distances(exact: World, small: World, tmp_path: Path) -> None:
    one, other = exact.match(tmp_path / "exact.json"), small.match(tmp_path / "small.json")
    for a, b in zip(one.objects, other.objects, strict=True):
        assert a.status == b.status
        distances = {candidate.asset: candidate.distance for candidate in a.by_distance}
        for candidate in b.by_distance:
            assert candidate.distance == pytest.approx(distances[candidate.asset], rel=0.05, abs=0.05)
        if a.cousins and a.label != "bowl":  # one blank box is as good as another
            assert a.cousins[0].asset == b.cousins[0].asset


def test_more_dimensions_than_features_are_refused(tmp_path: Path) -> None:
    with refused("E-FEATURE-DIMENSIONS"):
        World(tmp_path, dimensions=270)


def test_a_shortlist_keeps_what_looks_nearest_as_a_whole(exact: World) -> None:
    options = MatchingConfig(shortlist=3)
    encoder, store = make_encoder(options), opened(exact)
    library = read_json(Library, exact.library)
    everything = Candidates(library.assets, [], "")
    item = SceneObject(id="a", label="box", mask=1, status="failed", reason="nothing is known of it")
    with SnapshotFile(exact.snapshots[0]) as shard:
        for name in shard.sidecar.assets:
            query = make_query(shard.views(name)[5], encoder)
            assert query is not None
            kept = shortlist(query, everything, item, store, options)
            assert len(kept.assets) == 3 and name in [entry.id for entry in kept.assets]
            assert kept.assets == [entry for entry in library.assets if entry in kept.assets]
            assert shortlist(query, everything, item, store, MatchingConfig()) is everything


def test_a_shortlist_keeps_what_is_called_so(exact: World) -> None:
    """Of thousands of models many look nearer as a whole than any of the right category."""
    options = MatchingConfig(shortlist=1)
    encoder, store = make_encoder(options), opened(exact)
    library = read_json(Library, exact.library)
    item = SceneObject(id="a", label="box", mask=1, status="failed", reason="nothing is known of it")
    with SnapshotFile(exact.snapshots[0]) as shard:
        first, *others = shard.sidecar.assets
        query = make_query(shard.views(first)[5], encoder)
    assert query is not None
    known = {entry.id: entry.category for entry in library.assets}
    other = next(name for name in others if known[name] != known[first])
    for meant in (first, other):
        labels = [CategoryMatch(category=known[name], distance=float(name != meant)) for name in (first, other)]
        kept = shortlist(query, Candidates(library.assets, labels, ""), item, store, options)
        assert [entry.category for entry in kept.assets] == [known[meant]]


def test_of_a_shortlist_only_its_models_are_ranked(exact: World, tmp_path: Path) -> None:
    everything = exact.match(tmp_path / "all.json").objects[0]
    short = exact.match(tmp_path / "short.json", shortlist=2).objects[0]
    assert len(everything.by_distance) > len(short.by_distance) == 2
    for name in ("asset", "distance", "orientation"):
        assert getattr(short.cousins[0], name) == getattr(everything.cousins[0], name)


def test_up_of_a_camera_that_looks_down() -> None:
    world_from_camera = look_at([0, 0, 1.4], [2, 1, 0.2])
    np.testing.assert_allclose(up_of_camera(np.arctan2(1.2, np.sqrt(5))), world_from_camera[2, :3], atol=1e-12)
    assert up_of_camera(None) is None
