"""Matching: the patch encoder hog, and what it makes of masks and depth."""

from dataclasses import replace

import numpy as np

from roomkin.stages.config.matching import MatchingConfig
from roomkin.stages.geometry.masks import cut, foreground, pixel_bounds
from roomkin.stages.matching.descriptors import object_frame, patch_normals
from roomkin.stages.matching.encoders import make_encoder, settings_digest
from roomkin.stages.matching.encoders.hog import CELL_STEPS, GRADIENT_BINS, GRADIENT_COLUMNS, descriptors
from roomkin.stages.matching.ranking import make_query
from tests.unit.matching_data import view_of_box

HOG = MatchingConfig()


def test_only_foreground_patches_are_encoded() -> None:
    view = view_of_box(0.4)
    patches = make_encoder(HOG).encode([view])[0]
    assert patches.features.shape == (len(patches.positions), 270)
    assert 0 < len(patches.features) < 16 * 16
    cropped = cut(view)
    assert cropped.mask.any(axis=0).all() and cropped.mask.any(axis=1).all()
    assert np.abs(patches.positions).max() < 1
    empty = make_encoder(HOG).encode([replace(view, mask=np.zeros_like(view.mask))])[0]
    assert len(empty.features) == len(empty.positions) == 0


def test_background_does_not_matter() -> None:
    view = view_of_box(0.4)
    noise = np.random.default_rng(0).integers(0, 255, view.rgb.shape, dtype=np.uint8)
    other = replace(
        view, rgb=np.where(view.mask[..., None], view.rgb, noise), depth=np.where(view.mask, view.depth, 9.0)
    )
    for a, b in zip(make_encoder(HOG).encode([view])[0], make_encoder(HOG).encode([other])[0], strict=True):
        np.testing.assert_array_equal(a, b)


def test_gradients_are_unit_and_blind_to_inverted_colors() -> None:
    view = view_of_box(0.0)
    inside = replace(view, mask=np.zeros_like(view.mask))
    inside.mask[50:80, 50:80] = True
    gradients = make_encoder(HOG).encode([inside])[0].features[:, :GRADIENT_COLUMNS]
    inverted = make_encoder(HOG).encode([replace(inside, rgb=254 - inside.rgb)])[0].features[:, :GRADIENT_COLUMNS]
    np.testing.assert_allclose(gradients, inverted, atol=0.03)  # grey 127 inverts to itself; resizing rounds
    assert np.linalg.norm(gradients, axis=1).max() <= 1.0 + 1e-5


def test_normals_of_a_box_are_those_of_its_faces() -> None:
    yaw = 0.5
    normals = patch_normals(cut(view_of_box(yaw)), 16)
    found = normals[np.abs(np.linalg.norm(normals, axis=-1) - 1) < 1e-3]
    # frame (right, up, towards): the camera on +x sees front (cos, sin) and side; its right is +y
    expected = {"top": (0, 1, 0), "front": (np.sin(yaw), 0, np.cos(yaw)), "side": (-np.cos(yaw), 0, np.sin(yaw))}
    for name, normal in expected.items():
        share = ((found @ np.array(normal)) > np.cos(0.03)).mean()
        assert share > 0.05, f"{name}: {share:.2f} of the patches"
    assert ((found @ np.array(list(expected.values())).T).max(axis=1) > np.cos(0.03)).mean() > 0.6


def test_upright_normals_do_not_depend_on_where_the_camera_is() -> None:
    base = patch_normals(cut(view_of_box(0.5)), 16)
    for other in (view_of_box(0.5, elevation=0.6), view_of_box(0.5, distance=5.0), view_of_box(0.5, offset=0.15)):
        moved = patch_normals(cut(other), 16)
        fronts = [n[(n @ np.array([np.sin(0.5), 0, np.cos(0.5)])) > 0.97].mean(axis=0) for n in (base, moved)]
        assert np.linalg.norm(fronts[0] - fronts[1]) < 0.05


def test_object_frame_without_gravity_looks_along_the_ray() -> None:
    center = np.array([0.5, 0.2, 2.0])
    frame = object_frame(center, None)
    np.testing.assert_allclose(frame.T @ frame, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(frame[:, 2], -center / np.linalg.norm(center))
    assert frame[:, 1] @ [0, -1, 0] > 0.9
    assert np.isfinite(object_frame(center, center / np.linalg.norm(center))).all()  # seen from straight above


def test_missing_depth_takes_normals_out_of_the_comparison() -> None:
    view, encoder = view_of_box(0.4), make_encoder(HOG)
    known = view.depth.copy()  # type: ignore[union-attr]
    known[:, :70] = 0  # more than half of the object
    with_depth = make_query(view, encoder)
    for poorer in (replace(view, depth=None), replace(view, depth=known)):
        without = make_query(poorer, encoder)
        assert with_depth is not None and without is not None
        assert (with_depth.patches.shape[1], without.patches.shape[1]) == (272, 245)


def test_position_counts_by_itself_where_there_are_no_normals() -> None:
    options = MatchingConfig.model_validate({"hog": {"normals": 0.5, "position": 0.2, "position_alone": 0.7}})
    for depth, parts in ((True, (1.0, 0.5, 0.2)), (False, (1.0, 0.0, 0.7))):
        weights = make_encoder(options).weights(depth)
        for columns, weight in zip(np.split(weights, [GRADIENT_COLUMNS, len(weights) - 2]), parts, strict=True):
            np.testing.assert_allclose(columns, weight)


def test_crops_of_a_few_pixels_are_encoded() -> None:
    view = view_of_box(0.4)
    tiny = np.zeros_like(view.mask)
    tiny[60:63, 64:66] = True
    patches = make_encoder(HOG).encode([replace(view, mask=tiny)])[0]
    assert len(patches.features) and np.isfinite(patches.features).all()
    assert pixel_bounds(tiny) == (64, 60, 66, 63)
    thin = np.zeros((96, 96), np.float32)
    thin[:, 47] = 1
    assert foreground(thin, 4, 4).any()


def test_settings_name_the_store() -> None:
    digests = {settings_digest(o, make_encoder(o)) for o in (HOG, MatchingConfig(hog={"grid": 12}))}  # type: ignore[arg-type]
    assert len(digests) == 2
    heavier = MatchingConfig(hog={"normals": 0.5})  # type: ignore[arg-type]
    assert settings_digest(heavier, make_encoder(heavier)) in digests  # weights are applied when comparing


def test_a_patch_is_described_by_the_cells_around_it_at_every_scale() -> None:
    cells = np.zeros((17, 17, GRADIENT_BINS), np.float32)
    cells[8, 8] = 1.0
    found = descriptors(cells).reshape(17, 17, len(CELL_STEPS), 3, 3, GRADIENT_BINS)
    away = np.arange(17) - 8
    for number, scale in enumerate(CELL_STEPS):
        reached = np.abs(away[:, None] + scale * np.arange(-1, 2)) < scale  # (17, 3): a block that holds the lit cell
        expected = reached[:, None, :, None] & reached[None, :, None, :]
        assert ((found[:, :, number] > 0).all(axis=-1) == expected).all(), scale
