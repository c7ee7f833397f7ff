# SPDX-License-Identifier: Apache-2.0
"""Training of the variational autoencoder with Adam."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.arrays import FloatArray
from livecl.errors import LiveclError
from livecl.training.adam import Adam, settling
from livecl.vae.model import Loss, Vae

#: Share of the learning rate left at the end.
SETTLE = 0.05


@dataclasses.dataclass(frozen=True)
class Training:
    """Outcome of a training.

    Attributes
    ----------
    model : Vae
        The trained model.
    losses : (steps, 2) float64
        Cross-entropy and divergence of each step's batch before the step, nats per picture: the loss curve.
    """

    model: Vae
    losses: FloatArray


def train_vae(
    images: ArrayLike,
    *,
    num_latents: int = 10,
    hidden: tuple[int, ...] = (256, 256),
    steps: int = 2500,
    batch: int = 128,
    learning_rate: float = 2e-3,
    seed: int = 0,
    callback: Callable[[int, Loss], None] | None = None,
) -> Training:
    """Train a model from scratch.

    Parameters
    ----------
    images : (N, H, W) array_like
        Grey pictures in [0, 1].
    num_latents : int
        Number of latents of a picture.
    hidden : tuple of int
        Units of the encoder's hidden layers; the decoder has them in reverse.
    steps : int
        Steps of Adam.
    batch : int
        Pictures per step; fewer if there are fewer. Each epoch has its own random order.
    learning_rate : float
        Adam's step; from the middle of the training it falls to a twentieth.
    seed : int
        Same pictures, options and seed, on the same machine: same model, to the last bit.
    callback : callable, optional
        Called after each step with the number of steps done and the loss before the step.

    Returns
    -------
    Training
        The model and its loss curve.

    Raises
    ------
    LiveclError
        If the loss is no longer finite.
    """
    for name, value in (("steps", steps), ("batch", batch)):
        if value < 1:
            raise ValueError(f"{name}: got {value}, wanted at least 1")
    if not learning_rate > 0:
        raise ValueError(f"learning_rate: got {learning_rate}, wanted a positive number")
    pictures = np.asarray(images, np.float32)
    if pictures.ndim != 3 or not pictures.size:
        raise ValueError(f"images: shape {pictures.shape}, wanted (N, H, W)")
    rng = np.random.default_rng(seed)
    model = Vae.start((pictures.shape[1], pictures.shape[2]), hidden, num_latents, rng)
    adam = Adam.start((1, model.parameters.size))
    losses = np.empty((steps, 2))
    order: NDArray[np.int64] = np.empty(0, np.int64)
    batch = min(batch, len(pictures))
    for step in range(steps):
        if len(order) < batch:
            order = rng.permutation(len(pictures))
        chosen, order = order[:batch], order[batch:]
        noise = rng.normal(size=(batch, num_latents))
        loss, gradient = model.loss_and_gradient(pictures[chosen], noise)
        if not np.isfinite(loss.total):
            raise LiveclError(f"step {step}: the loss is not finite; train with a smaller learning_rate")
        model.parameters[:] += adam.step(gradient[None], learning_rate * settling(step / steps, SETTLE))[0]
        losses[step] = loss.cross_entropy, loss.divergence
        if callback is not None:
            callback(step + 1, loss)
    return Training(model, losses)
