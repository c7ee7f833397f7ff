# SPDX-License-Identifier: Apache-2.0
"""The autoencoder: each part's gradient and the whole one against differences, training, files, latents."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from reference.differences import by_small_steps
from scipy.integrate import trapezoid

from livecl import vae_layers
from livecl.digit_strokes import draw_digits
from livecl.errors import LiveclError
from livecl.vae import Loss, Vae
from livecl.vae_pictures import LIMIT, enlarge, interpolate_latents, latent_grid
from livecl.vae_training import Training, train_vae

#: Of a gradient's length: what tests/reference/differences.py says of its error, for sums of about unit size.
RELATIVE = 1e-6


def check_gradients(
    value: Callable[..., np.ndarray | float], arguments: Sequence[np.ndarray], gradients: Sequence[np.ndarray]
) -> None:
    """Compare gradients of a scalar function with differences, argument by argument."""
    for index, gradient in enumerate(gradients):

        def of_one(x: np.ndarray, index: int = index) -> np.ndarray:
            return np.atleast_1d(value(*arguments[:index], x, *arguments[index + 1 :]))

        expected = by_small_steps(of_one, arguments[index])[0].reshape(gradient.shape)
        assert np.linalg.norm(expected) > 0
        assert np.linalg.norm(gradient - expected) <= RELATIVE * np.linalg.norm(expected)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(0)


def test_dense(rng: np.random.Generator) -> None:
    x, weights, bias, d_y = (rng.normal(size=shape) for shape in ((4, 5), (5, 3), 3, (4, 3)))
    np.testing.assert_allclose(vae_layers.dense_forward(x, weights, bias)[1, 2], x[1] @ weights[:, 2] + bias[2])
    check_gradients(
        lambda *arguments: (vae_layers.dense_forward(*arguments) * d_y).sum(),
        (x, weights, bias),
        vae_layers.dense_backward(d_y, x, weights),
    )


def test_silu(rng: np.random.Generator) -> None:
    x, d_y = rng.normal(scale=3, size=(4, 5)), rng.normal(size=(4, 5))
    np.testing.assert_allclose(vae_layers.silu_forward(x), x / (1 + np.exp(-x)))
    check_gradients(lambda x: (vae_layers.silu_forward(x) * d_y).sum(), (x,), (vae_layers.silu_backward(d_y, x),))


def test_mlp(rng: np.random.Generator) -> None:
    shapes = ((5, 4), (4,), (4, 3), (3,), (3, 2), (2,))
    x, d_y, parts = rng.normal(size=(6, 5)), rng.normal(size=(6, 2)), [rng.normal(size=shape) for shape in shapes]

    def layers(parts: Sequence[np.ndarray]) -> list[vae_layers.Dense]:
        return list(zip(parts[::2], parts[1::2], strict=True))

    _, given = vae_layers.mlp_forward(x, layers(parts))
    d_x, d_layers = vae_layers.mlp_backward(d_y, given, layers(parts))
    check_gradients(
        lambda x, *parts: (vae_layers.mlp_forward(x, layers(parts))[0] * d_y).sum(),
        (x, *parts),
        (d_x, *(part for layer in d_layers for part in layer)),
    )


def test_sample(rng: np.random.Generator) -> None:
    mean, log_variance, noise, d_z = (rng.normal(size=(4, 3)) for _ in range(4))
    check_gradients(
        lambda mean, log_variance: (vae_layers.sample_forward(mean, log_variance, noise) * d_z).sum(),
        (mean, log_variance),
        vae_layers.sample_backward(d_z, log_variance, noise),
    )


def test_sample_has_the_moments(rng: np.random.Generator) -> None:
    noise = rng.normal(size=(40000, 1))
    z = vae_layers.sample_forward(np.full((40000, 1), 1.5), np.full((40000, 1), np.log(4)), noise)
    # Standard errors of the mean and deviation of 40 000 samples: 2 / 200 and 2 / sqrt(80 000); five of them.
    assert z.mean() == pytest.approx(1.5, abs=0.05)
    assert z.std() == pytest.approx(2, abs=0.036)


def test_divergence(rng: np.random.Generator) -> None:
    mean, log_variance = rng.normal(size=(4, 3)), rng.normal(size=(4, 3))
    check_gradients(
        vae_layers.divergence_forward, (mean, log_variance), vae_layers.divergence_backward(mean, log_variance)
    )


def test_divergence_against_its_integral() -> None:
    mean, variance = 0.7, 0.3
    z = np.linspace(mean - 12 * variance**0.5, mean + 12 * variance**0.5, 4001)
    density = np.exp(-((z - mean) ** 2) / (2 * variance)) / np.sqrt(2 * np.pi * variance)
    log_ratio = -((z - mean) ** 2) / (2 * variance) - 0.5 * np.log(variance) + z**2 / 2
    # The trapezoidal rule on a smooth function that is 1e-31 at both ends is exact to rounding.
    expected = trapezoid(density * log_ratio, z)
    found = vae_layers.divergence_forward(np.array([[mean]]), np.array([[np.log(variance)]]))
    assert found == pytest.approx(expected, rel=1e-12)
    assert vae_layers.divergence_forward(np.zeros((2, 3)), np.zeros((2, 3))) == 0


def test_cross_entropy(rng: np.random.Generator) -> None:
    logits, pixels = rng.normal(scale=3, size=(4, 5)), rng.uniform(size=(4, 5))
    s = 1 / (1 + np.exp(-logits))
    expected = -(pixels * np.log(s) + (1 - pixels) * np.log(1 - s)).sum() / 4
    assert vae_layers.cross_entropy_forward(logits, pixels) == pytest.approx(expected, rel=1e-12)
    check_gradients(
        lambda logits: vae_layers.cross_entropy_forward(logits, pixels),
        (logits,),
        (vae_layers.cross_entropy_backward(logits, pixels),),
    )


def test_cross_entropy_of_extreme_logits() -> None:
    logits, pixels = np.array([[1e4, -1e4, 1e4]]), np.array([[1.0, 0.0, 0.0]])
    assert vae_layers.cross_entropy_forward(logits, pixels) == 1e4
    np.testing.assert_array_equal(vae_layers.cross_entropy_backward(logits, pixels), [[0, 0, 1]])


@pytest.mark.parametrize("hidden", [(), (5,), (6, 4)])
def test_whole_loss(rng: np.random.Generator, hidden: tuple[int, ...]) -> None:
    model = Vae.start((3, 4), hidden, 2, rng)
    model.parameters[:] += rng.normal(scale=0.1, size=model.parameters.shape)
    images, noise = rng.uniform(size=(5, 3, 4)), rng.normal(size=(5, 2))
    loss, gradient = model.loss_and_gradient(images, noise)
    assert loss.total == loss.cross_entropy + loss.divergence

    def value(parameters: np.ndarray) -> float:
        return Vae((3, 4), hidden, 2, parameters).loss_and_gradient(images, noise)[0].total

    check_gradients(value, (model.parameters,), (gradient,))


def test_whole_loss_is_that_of_its_parts(rng: np.random.Generator) -> None:
    model = Vae.start((3, 4), (5,), 2, rng)
    images, noise = rng.uniform(size=(6, 3, 4)), rng.normal(size=(6, 2))
    mean, log_variance = model.encode(images)
    decoded = model.decode(mean + np.exp(log_variance / 2) * noise)
    cross_entropy = -(images * np.log(decoded) + (1 - images) * np.log(1 - decoded)).sum() / 6
    divergence = 0.5 * (mean**2 + np.exp(log_variance) - 1 - log_variance).sum() / 6
    loss = model.loss_and_gradient(images, noise)[0]
    assert loss.cross_entropy == pytest.approx(cross_entropy, rel=1e-12)
    assert loss.divergence == pytest.approx(divergence, rel=1e-12)


@pytest.fixture(scope="module")
def digits() -> np.ndarray:
    return draw_digits(200, seed=1).images


def small(digits: np.ndarray, **changes: object) -> Training:
    """A model that is trained in a second."""
    return train_vae(digits, **{"num_latents": 4, "hidden": (32,), "steps": 150, "batch": 50, **changes})


@pytest.fixture(scope="module")
def model(digits: np.ndarray) -> Vae:
    return small(digits).model


def test_training_learns(digits: np.ndarray) -> None:
    seen: list[tuple[int, Loss]] = []
    training = small(digits, callback=lambda step, loss: seen.append((step, loss)))
    assert [step for step, _ in seen] == list(range(1, 151))
    np.testing.assert_array_equal(training.losses, [(loss.cross_entropy, loss.divergence) for _, loss in seen])
    # The best that no latents can do: every pixel's mean, its cross-entropy with the pixels.
    mean = np.clip(digits.astype(np.float64).mean(axis=0), 1e-9, 1 - 1e-9)
    without = -(digits * np.log(mean) + (1 - digits) * np.log(1 - mean)).sum() / len(digits)
    assert training.losses[:5].sum(axis=1).mean() > 2 * without
    assert training.losses[-10:].sum(axis=1).mean() < without


def test_same_seed_same_bytes(tmp_path: Path, digits: np.ndarray) -> None:
    names = [tmp_path / name for name in ("a.npz", "b.npz", "c.npz")]
    for name, seed in zip(names, (0, 0, 1), strict=True):
        small(digits, steps=20, seed=seed).model.save(name)
    assert names[0].read_bytes() == names[1].read_bytes()
    assert names[0].read_bytes() != names[2].read_bytes()


def test_saved_and_loaded(tmp_path: Path, digits: np.ndarray, model: Vae) -> None:
    model.save(tmp_path / "model.npz")
    loaded = Vae.load(tmp_path / "model.npz")
    assert (loaded.size, loaded.hidden, loaded.num_latents) == ((28, 28), (32,), 4)
    np.testing.assert_array_equal(loaded.parameters, model.parameters)
    np.testing.assert_array_equal(loaded.encode(digits[:3])[0], model.encode(digits[:3])[0])


@pytest.mark.parametrize("kind", ["missing", "text", "other arrays", "pickled", "cut off", "wrong length"])
def test_no_saved_model(tmp_path: Path, model: Vae, kind: str) -> None:
    path = tmp_path / "model.npz"
    facts = {"format": 1, "size": (28, 28), "hidden": (32,), "num_latents": 4}
    if kind == "text":
        path.write_text("no model")
    elif kind == "other arrays":
        np.savez(path, x=np.zeros(3))
    elif kind == "pickled":
        np.savez(path, parameters=np.array([{}], dtype=object), **facts)
    elif kind == "cut off":
        model.save(path)
        path.write_bytes(path.read_bytes()[:-1000])
    elif kind == "wrong length":
        np.savez(path, parameters=np.zeros(7), **facts)
    with pytest.raises(LiveclError, match=r"model\.npz' is not a saved VAE"):
        Vae.load(path)


def test_interpolation(digits: np.ndarray, model: Vae) -> None:
    frames = interpolate_latents(model, digits[0], digits[1], 5)
    assert frames.shape == (5, 28, 28)
    means = model.encode(digits[:2])[0]
    # Matrix products of other shapes may be summed in another order: a few eps of sums of at most 10.
    np.testing.assert_allclose(frames[[0, 4]], model.decode(means), atol=1e-13)
    np.testing.assert_allclose(frames[2], model.decode(means.mean(axis=0)[None])[0], atol=1e-13)


def test_grid(digits: np.ndarray, model: Vae) -> None:
    grid = latent_grid(model, digits[:4], 3, 5)
    assert grid.shape == (3, 5, 28, 28)
    means = model.encode(digits[:4])[0]
    np.testing.assert_allclose(grid[[0, 0, -1, -1], [0, -1, 0, -1]], model.decode(means), atol=1e-13)
    np.testing.assert_allclose(grid[1, 2], model.decode(means.mean(axis=0)[None])[0], atol=1e-13)
    np.testing.assert_allclose(grid[0], interpolate_latents(model, digits[0], digits[1], 5), atol=1e-13)
    np.testing.assert_allclose(grid[:, -1], interpolate_latents(model, digits[1], digits[3], 3), atol=1e-13)


def test_enlarging_a_flat_picture() -> None:
    grey = np.linspace(0, 1, 5)
    flat = np.broadcast_to(grey[:, None, None], (5, 4, 4))
    # Black and white stay so; between them, what the cut-off at exp(-LIMIT) is worth.
    np.testing.assert_allclose(enlarge(flat, 9)[:, 3, 3], grey, atol=2 * np.exp(-LIMIT))
    np.testing.assert_allclose(enlarge(flat, 9)[[0, 4], 3, 3], [0, 1], atol=1e-12)


def test_enlarging_keeps_edges_in_place_and_sharp() -> None:
    # A ramp of logits across an edge at x = 3.25 px of 8 is still there at x = 26 of 64, and as steep for each pixel
    # of the small picture; cubic interpolation of a straight line is the line, away from the border.
    picture = 1 / (1 + np.exp(-1.5 * (np.arange(8) + 0.5 - 3.25)))
    larger = enlarge(np.tile(picture, (1, 8, 1)), 64)[0, 32]
    x = (np.arange(64) + 0.5) / 8
    near = (x > 2) & (x < 4.5)
    expected = 1 / (1 + np.exp(-1.5 * (x - 3.25)))
    np.testing.assert_allclose(larger[near], expected[near], atol=2 * np.exp(-LIMIT))


def test_arguments(digits: np.ndarray, model: Vae) -> None:
    for call, message in (
        (lambda: model.encode(digits[0]), r"images: shape \(28, 28\), wanted \(B, 28, 28\)"),
        (lambda: model.encode(digits[:1] * 255), r"images: from 0 to 255, wanted within \[0, 1\]"),
        (lambda: model.encode(digits[:1] * np.nan), r"images: from nan to nan"),
        (lambda: model.decode(np.zeros((2, 3))), r"latents: shape \(2, 3\), wanted \(B, 4\)"),
        (lambda: model.loss_and_gradient(digits[:2], np.zeros((3, 4))), r"noise: shape \(3, 4\), wanted \(2, 4\)"),
        (lambda: interpolate_latents(model, digits[0], digits[1], 1), "count: got 1, wanted at least 2"),
        (lambda: latent_grid(model, digits[:4], 1, 2), "rows: got 1, wanted at least 2"),
        (lambda: latent_grid(model, digits[:4], 2, 1), "columns: got 1, wanted at least 2"),
        (lambda: latent_grid(model, digits[:3], 2, 2), "corners: 3 pictures, wanted 4"),
        (lambda: enlarge(digits[0], 50), r"pictures: shape \(28, 28\), wanted \(B, H, W\)"),
        (lambda: enlarge(digits, 0), "size: got 0, wanted at least 1"),
        (lambda: small(digits, steps=0), "steps: got 0, wanted at least 1"),
        (lambda: small(digits, batch=0), "batch: got 0, wanted at least 1"),
        (lambda: small(digits, learning_rate=0), "learning_rate: got 0, wanted a positive number"),
        (lambda: small(digits, hidden=(0,)), r"hidden: got \(0,\), wanted numbers of at least 1"),
        (lambda: small(digits, num_latents=0), r"num_latents: got \(0,\), wanted numbers of at least 1"),
        (lambda: small(digits[0]), r"images: shape \(28, 28\), wanted \(N, H, W\)"),
        (lambda: Vae((2, 2), (), 1, np.zeros(3)), r"parameters: shape \(3,\), wanted \(18,\)"),
    ):
        with pytest.raises(ValueError, match=message):
            call()


def test_training_that_diverges_stops(digits: np.ndarray) -> None:
    with (
        np.errstate(all="ignore"),
        pytest.raises(LiveclError, match=r"step \d+: the loss is not finite; train with a smaller learning_rate"),
    ):
        small(digits, learning_rate=1e6)
