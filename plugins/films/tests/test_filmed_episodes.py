"""Films of rollouts, on a toy task, and of demonstrations, on a real one: which episodes, the same bytes."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from roomkin.plugins.films import rollouts
from roomkin.plugins.films.kinds import Film, Films
from roomkin.plugins.films.rollouts import RolloutFilms, add_caption, pick_episodes
from roomkin.stages.contracts.archives import unpack
from roomkin.stages.contracts.files import read_json
from roomkin.stages.demonstrations.collect import run
from roomkin.stages.evaluation.vector_env import RolloutEpisode
from tests.unit.demo_assets import an_asset
from tests.unit.test_demonstrations import TASK, experiment
from tests.unit.test_rollout import Made, evaluate, folder, toy_simulator

__all__ = ["folder", "toy_simulator"]
MODULE = ("roomkin.plugins.films.rollouts",)


class ToyRenderer:
    """Films without a renderer: a grey that gets lighter."""

    def film(self, recording: list[int], frames: int) -> list[np.ndarray]:
        return [np.full((64, 80, 3), 10 * (frame + len(recording)) % 256, np.uint8) for frame in range(frames)]


@pytest.fixture
def toy_renderer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rollouts, "FilmRenderer", ToyRenderer)


def read_films(archive: Path) -> list[Film]:
    return read_json(Films, unpack(archive, "") / "films.json").films


@pytest.mark.usefixtures("toy_renderer")
def test_film_shows_a_success_and_a_failure() -> None:
    cab = an_asset("cab")
    episodes = [RolloutEpisode(cab, i, success=i in (2, 3), steps=9, recording=[i] if i else None) for i in range(6)]  # type: ignore[arg-type]
    assert [episode.seed for episode in pick_episodes(episodes)] == [2, 1]
    films = RolloutFilms()
    films.take(episodes, "twin")
    assert {film.asset for film, _ in films.films} == {"cab"}
    assert [(film.seed, film.file) for film, _ in films.films] == [(1, "twin_failure.webp"), (2, "twin_success.webp")]
    assert add_caption(*films.films[0]).shape == (40 + 192 * 4 // 5, 8 * 192, 3)
    for part, count in ((episodes[4:], 1), ([], 0)):
        films = RolloutFilms()
        films.take(part, "twin")
        assert len(films.films) == count


@pytest.mark.usefixtures("toy_renderer")
def test_rollouts_are_filmed_the_same_way_twice(folder: Path, tmp_path: Path, toy_simulator: Made) -> None:
    for name in ("a", "b"):
        evaluate(folder, tmp_path / name / "rollouts.csv", films=MODULE)
    assert sorted(path.name for path in (tmp_path / "a").iterdir()) == ["film.png", "films.zip", "rollouts.csv"]
    films = read_films(tmp_path / "a" / "films.zip")
    assert {film.role for film in films} == {"twin", "cousin_2"}
    with Image.open(unpack(tmp_path / "a" / "films.zip", "") / films[0].file) as opened:
        assert opened.n_frames == 16 and opened.size == (80, 64)  # type: ignore[attr-defined]
    for name in ["film.png", "rollouts.csv", "films.zip"]:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes(), name
    evaluate(folder, tmp_path / "plain" / "rollouts.csv")
    assert (tmp_path / "plain" / "rollouts.csv").read_bytes() == (tmp_path / "a" / "rollouts.csv").read_bytes()


@pytest.mark.usefixtures("toy_renderer")
def test_every_test_role_is_filmed(folder: Path, tmp_path: Path, toy_simulator: Made) -> None:
    evaluate(folder, tmp_path / "a.csv", films=MODULE, assets=2, asset_rollouts=3)
    assert {film.role for film in read_films(tmp_path / "films.zip")} == {"twin", "cousin_2", "test"}
    evaluate(folder, tmp_path / "b.csv", ("all",), films=MODULE, test_assets=["trained"])
    assert {film.role for film in read_films(tmp_path / "films.zip")} == {"trained"}


def test_the_first_success_of_demonstrations_is_filmed(tmp_path: Path) -> None:
    inputs = experiment(tmp_path)
    for name in ("a", "b"):
        run(
            **inputs, role="twin", episodes=2, out=tmp_path / name / "episodes.h5", seed=3, options='{"noise": 0.004}',
            films=("roomkin.plugins.films.writing",), task_options=json.dumps(TASK),
        )  # fmt: skip
    assert (tmp_path / "a" / "films.zip").read_bytes() == (tmp_path / "b" / "films.zip").read_bytes()
    (filmed,) = read_films(tmp_path / "a" / "films.zip")
    with Image.open(unpack(tmp_path / "a" / "films.zip", "") / filmed.file) as opened:
        assert opened.n_frames == 16  # type: ignore[attr-defined]
    film = cv2.imread(str(tmp_path / "a" / "film.png"))
    assert film is not None and len(np.unique(film.reshape(-1, 3), axis=0)) > 50
