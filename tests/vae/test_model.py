# SPDX-License-Identifier: Apache-2.0
"""The variational autoencoder: its gradients, its training, its file, and the ways through its latents.

Gradients are compared with central differences in float64, to a relative 1e-6: at a step h = 1e-5 they are off by about
h^2 = 1e-10 of the third derivative, and by eps / h = 2e-11 of the value, both for functions of about unit size; the
rest allows for sums of values larger than their gradient.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from livecl.errors import LiveclError
from livecl.vae.drawn_digits import draw_digits
from livecl.vae.model import Loss, Vae, interpolate_latents, latent_grid
from livecl.vae.parts import (
    cross_entropy_backward,
    cross_entropy_forward,
    dense_backward,
    dense_forward,
    divergence_backward,
    divergence_forward,
    mlp_backward,
    mlp_forward,
    sample_backward,
    sample_forward,
    sigmoid,
    silu_backward,
    silu_forward,
)
from livecl.vae.training import train_vae

FloatArray = NDArray[np.float64]

STEP, RELATIVE = 1e-5, 1e-6


def _assert_gradient(loss: Callable[[], float], x: FloatArray, d_x: FloatArray) -> None:
    """Compare dL/dx with central differences, relative to its norm, with `x` changed in place."""
    assert d_x.shape == x.shape
    expected = np.empty_like(x)
    for index in np.ndindex(x.shape):
        kept = x[index]
        x[index] = kept + STEP
        above = loss()
        x[index] = kept - STEP
        below = loss()
        x[index] = kept
        expected[index] = (above - below) / (2 * STEP)
    assert np.linalg.norm(expected) > 0
    assert np.linalg.norm(d_x - expected) <= RELATIVE * np.linalg.norm(expected)


def _normal(*shape: int, seed: int = 0) -> FloatArray:
    return np.random.default_rng((seed, *shape)).normal(size=shape)


def _model(seed: int = 0) -> Vae:
    return Vae.start((3, 4), (6, 5), 2, np.random.default_rng(seed))


def _pictures(count: int, seed: int = 0) -> FloatArray:
    return np.random.default_rng(seed).uniform(size=(count, 3, 4))


def test_dense_gradient() -> None:
    x, weights, bias, d_y = _normal(4, 3), _normal(3, 5), _normal(5), _normal(4, 5)

    def loss() -> float:
        return float(np.sum(d_y * dense_forward(x, weights, bias)))

    for value, gradient in zip((x, weights, bias), dense_backward(d_y, x, weights), strict=True):
        _assert_gradient(loss, value, gradient)


def test_silu_known_values_and_gradient() -> None:
    assert silu_forward(np.array([0.0]))[0] == 0
    np.testing.assert_allclose(silu_forward(np.array([1.0, -1.0])), [1 / (1 + np.exp(-1)), -1 / (1 + np.e)], rtol=1e-14)
    x, d_y = 3 * _normal(4, 5), _normal(4, 5, seed=1)
    _assert_gradient(lambda: float(np.sum(d_y * silu_forward(x))), x, silu_backward(d_y, x))


def test_mlp_gradient() -> None:
    layers = [(_normal(3, 4), _normal(4)), (_normal(4, 5), _normal(5)), (_normal(5, 2), _normal(2))]
    x, d_y = _normal(6, 3), _normal(6, 2)

    def loss() -> float:
        return float(np.sum(d_y * mlp_forward(x, layers)[0]))

    d_x, d_layers = mlp_backward(d_y, mlp_forward(x, layers)[1], layers)
    _assert_gradient(loss, x, d_x)
    for layer, d_layer in zip(layers, d_layers, strict=True):
        for value, gradient in zip(layer, d_layer, strict=True):
            _assert_gradient(loss, value, gradient)


def test_sample_gradient() -> None:
    mean, log_variance, noise, d_z = (_normal(4, 3, seed=seed) for seed in range(4))

    def loss() -> float:
        return float(np.sum(d_z * sample_forward(mean, log_variance, noise)))

    for value, gradient in zip((mean, log_variance), sample_backward(d_z, log_variance, noise), strict=True):
        _assert_gradient(loss, value, gradient)


def test_divergence_known_values_and_gradient() -> None:
    assert divergence_forward(np.zeros((3, 2)), np.zeros((3, 2))) == 0
    # Of a mean of 2 and a variance of e: (4 + e - 1 - 1) / 2, in each of two latents.
    found = divergence_forward(np.full((3, 2), 2.0), np.ones((3, 2)))
    assert found == pytest.approx(2 + np.e, rel=1e-14)
    mean, log_variance = _normal(4, 3), _normal(4, 3, seed=1)
    for value, gradient in zip((mean, log_variance), divergence_backward(mean, log_variance), strict=True):
        _assert_gradient(lambda: divergence_forward(mean, log_variance), value, gradient)


def test_cross_entropy_known_values_and_gradient() -> None:
    logits, pixels = 3 * _normal(4, 5), np.random.default_rng(1).uniform(size=(4, 5))
    share = 1 / (1 + np.exp(-logits))
    expected = -np.sum(pixels * np.log(share) + (1 - pixels) * np.log(1 - share)) / 4
    assert cross_entropy_forward(logits, pixels) == pytest.approx(expected, rel=1e-12)
    _assert_gradient(lambda: cross_entropy_forward(logits, pixels), logits, cross_entropy_backward(logits, pixels))


def test_large_numbers_do_not_overflow() -> None:
    large = np.array([[-1e4, 1e4]])
    assert sigmoid(large).tolist() == [[0, 1]]
    assert silu_forward(large).tolist() == [[0, 1e4]]
    assert silu_backward(np.ones((1, 2)), large).tolist() == [[0, 1]]
    assert cross_entropy_forward(large, np.array([[0.0, 1.0]])) == 0
    assert cross_entropy_forward(large, np.array([[1.0, 0.0]])) == 2e4


def test_gradient_of_the_whole_loss() -> None:
    # Biases start at 0; all parameters are moved so that no gradient is of a special case.
    model, images, noise = _model(), _pictures(5), _normal(5, 2)
    model.parameters[:] += 0.3 * _normal(model.parameters.size)
    _, gradient = model.loss_and_gradient(images, noise)
    _assert_gradient(lambda: model.loss_and_gradient(images, noise)[0].total, model.parameters, gradient)


def test_loss_is_that_of_its_parts() -> None:
    model, images, noise = _model(), _pictures(5), _normal(5, 2)
    loss, _ = model.loss_and_gradient(images, noise)
    mean, log_variance = model.encode(images)
    decoded = model.decode(mean + np.exp(log_variance / 2) * noise)
    expected = -np.sum(images * np.log(decoded) + (1 - images) * np.log(1 - decoded)) / 5
    assert loss.cross_entropy == pytest.approx(expected, rel=1e-12)
    assert loss.divergence == pytest.approx(divergence_forward(mean, log_variance), rel=1e-14)
    assert loss.total == loss.cross_entropy + loss.divergence


def test_training_lowers_the_loss_and_learns_the_pictures() -> None:
    images = draw_digits(20).images
    seen: list[tuple[int, Loss]] = []
    training = train_vae(
        images, num_latents=4, hidden=(48,), steps=300, batch=20, callback=lambda step, loss: seen.append((step, loss))
    )
    total = training.losses.sum(axis=1)
    assert total.shape == (300,)
    assert [step for step, _ in seen] == list(range(1, 301))
    assert [loss.total for _, loss in seen] == total.tolist()
    assert total[-20:].mean() < 0.5 * total[:3].mean()
    # The decoded picture is nearer to its own than the best that knows no picture: the mean of all.
    decoded = training.model.decode(training.model.encode(images)[0])
    assert np.square(decoded - images).mean() < 0.5 * np.square(images.mean(axis=0) - images).mean()


def test_same_seed_same_bytes() -> None:
    images = draw_digits(30).images
    first, again, other = (
        train_vae(images, num_latents=3, hidden=(16,), steps=20, batch=8, seed=seed) for seed in (5, 5, 6)
    )
    assert first.model.parameters.tobytes() == again.model.parameters.tobytes()
    assert first.losses.tobytes() == again.losses.tobytes()
    assert first.model.parameters.tobytes() != other.model.parameters.tobytes()


def test_a_batch_larger_than_the_set_is_the_set() -> None:
    images = draw_digits(5).images
    large, exact = (train_vae(images, num_latents=2, hidden=(4,), steps=3, batch=batch) for batch in (100, 5))
    assert large.model.parameters.tobytes() == exact.model.parameters.tobytes()


def test_training_that_diverges_stops() -> None:
    with (
        pytest.raises(LiveclError, match="loss is not finite; train with a smaller learning_rate"),
        np.errstate(all="ignore"),
    ):
        train_vae(draw_digits(10).images, num_latents=2, hidden=(8,), steps=50, learning_rate=1e6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"steps": 0}, "steps: got 0"),
        ({"batch": 0}, "batch: got 0"),
        ({"learning_rate": 0.0}, "learning_rate: got 0.0"),
        ({"learning_rate": float("nan")}, "learning_rate: got nan"),
        ({"num_latents": 0}, "num_latents: got 0"),
        ({"hidden": (4, 0)}, "hidden: got 4, 0"),
        ({"images": np.zeros((4, 4))}, r"images: shape \(4, 4\)"),
        ({"images": np.zeros((0, 4, 4))}, r"images: shape \(0, 4, 4\)"),
        ({"images": np.full((2, 4, 4), 1.5)}, "images: from 1.5 to 1.5"),
        ({"images": np.full((2, 4, 4), np.nan)}, "images: from nan"),
    ],
)
def test_bad_training_arguments_name_themselves(change: dict[str, object], message: str) -> None:
    arguments = {"images": _pictures(3), "hidden": (4,), "steps": 2} | change
    with pytest.raises(ValueError, match=message):
        train_vae(arguments.pop("images"), **arguments)  # type: ignore[arg-type]


def test_saved_model_is_read_back(tmp_path: Path) -> None:
    model = _model()
    model.save(tmp_path / "a.npz")
    loaded = Vae.load(tmp_path / "a.npz")
    assert (loaded.size, loaded.hidden, loaded.num_latents) == (model.size, model.hidden, model.num_latents)
    assert loaded.parameters.tobytes() == model.parameters.tobytes()
    assert np.array_equal(loaded.decode(_normal(3, 2)), model.decode(_normal(3, 2)))
    loaded.save(tmp_path / "b.npz")
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_damaged_file_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "model.npz"
    _model().save(file)
    whole = file.read_bytes()
    middle = len(whole) // 4
    damaged = {
        "empty": b"",
        "cut off": whole[: len(whole) // 2],
        "no archive": b"not a model",
        "changed": whole[:middle] + bytes(255 - byte for byte in whole[middle : middle + 8]) + whole[middle + 8 :],
    }
    for data in damaged.values():
        file.write_bytes(data)
        with pytest.raises(LiveclError, match="is not a saved VAE"):
            Vae.load(file)
    with pytest.raises(LiveclError, match=r"none\.npz' is not a saved VAE"):
        Vae.load(tmp_path / "none.npz")


def test_each_changed_byte_is_refused_or_without_effect(tmp_path: Path) -> None:
    file = tmp_path / "model.npz"
    model = Vae.start((1, 2), (1,), 1, np.random.default_rng(0))
    model.save(file)
    whole = file.read_bytes()
    for place in range(len(whole)):
        file.write_bytes(whole[:place] + bytes([whole[place] ^ 0xFF]) + whole[place + 1 :])
        try:
            loaded = Vae.load(file)
        except LiveclError:
            continue
        assert loaded.parameters.tobytes() == model.parameters.tobytes()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"format": np.array(2)}, "format 2, wanted 1"),
        ({"parameters": np.zeros(5)}, r"parameters: shape \(5,\)"),
        ({"size": np.array([3])}, "not enough values"),
        ({"num_latents": np.array(-1)}, "num_latents: got -1"),
        ({"parameters": None}, "parameters"),
        ({"parameters": np.full(_model().parameters.size, np.nan)}, "parameters: some are not finite"),
    ],
)
def test_file_with_other_content_is_refused(tmp_path: Path, change: dict[str, object], message: str) -> None:
    _model().save(tmp_path / "a.npz")
    with np.load(tmp_path / "a.npz") as file:
        arrays = {name: value for name, value in (dict(file) | change).items() if value is not None}
    np.savez(tmp_path / "b.npz", **arrays)
    with pytest.raises(LiveclError, match=message):
        Vae.load(tmp_path / "b.npz")


def test_a_single_array_is_no_model(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.zeros(3))
    with pytest.raises(LiveclError, match="is not a saved VAE"):
        Vae.load(tmp_path / "a.npy")


def test_interpolation_ends_at_the_decoded_pictures() -> None:
    # The rows of a product are summed in an order that may depend on their number: a few eps of values up to 1.
    model, (a, b) = _model(), _pictures(2)
    found = interpolate_latents(model, a, b, 7)
    assert found.shape == (7, 3, 4)
    ends = model.decode(model.encode(np.stack([a, b]))[0])
    np.testing.assert_allclose(found[[0, -1]], ends, rtol=0, atol=1e-14)
    np.testing.assert_allclose(found, interpolate_latents(model, b, a, 7)[::-1], rtol=0, atol=1e-14)
    middle = model.decode(model.encode(np.stack([a, b]))[0].mean(axis=0, keepdims=True))[0]
    np.testing.assert_allclose(found[3], middle, rtol=0, atol=1e-14)


def test_grid_has_the_decoded_pictures_in_its_corners() -> None:
    model, corners = _model(), _pictures(4)
    grid = latent_grid(model, corners, 3, 5)
    assert grid.shape == (3, 5, 3, 4)
    ends = model.decode(model.encode(corners)[0])
    for place, end in zip(((0, 0), (0, -1), (-1, 0), (-1, -1)), ends, strict=True):
        np.testing.assert_allclose(grid[place], end, rtol=0, atol=1e-14)


def test_edges_of_the_grid_are_interpolations() -> None:
    model, corners = _model(), _pictures(4)
    grid = latent_grid(model, corners, 4, 5)
    np.testing.assert_allclose(grid[0], interpolate_latents(model, corners[0], corners[1], 5), rtol=0, atol=1e-14)
    np.testing.assert_allclose(grid[:, -1], interpolate_latents(model, corners[1], corners[3], 4), rtol=0, atol=1e-14)


def test_bad_ways_are_refused() -> None:
    model, pictures = _model(), _pictures(4)
    with pytest.raises(ValueError, match="count: got 1"):
        interpolate_latents(model, pictures[0], pictures[1], 1)
    with pytest.raises(ValueError, match="rows: got 1"):
        latent_grid(model, pictures, 1, 3)
    with pytest.raises(ValueError, match="columns: got 0"):
        latent_grid(model, pictures, 3, 0)
    with pytest.raises(ValueError, match="corners: 3 pictures, wanted 4"):
        latent_grid(model, pictures[:3], 3, 3)
    with pytest.raises(ValueError, match=r"latents: shape \(3,\)"):
        model.decode(np.zeros(3))
    with pytest.raises(ValueError, match=r"noise: shape \(4, 3\)"):
        model.loss_and_gradient(pictures, np.zeros((4, 3)))
