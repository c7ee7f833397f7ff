# SPDX-License-Identifier: Apache-2.0
"""A variational autoencoder (Kingma and Welling 2014) of small grey pictures, and paths between their latents.

The encoder turns a picture x into the mean and log variance of Gaussian latents z, the decoder turns latents into the
logits of the pixels. Both are dense layers with SiLU between them. The loss is

    L = cross-entropy(x, decoder(z)) + KL(N(mean, variance) || N(0, 1)),    z = mean + sqrt(variance) noise

which bounds -log p(x) from above. The parts and their gradients are in livecl/vae/parts.py.
"""

from __future__ import annotations

import dataclasses
import io
import os
import zipfile
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from livecl.arrays import FloatArray
from livecl.errors import LiveclError
from livecl.files import write_atomically
from livecl.vae.parts import (
    Dense,
    cross_entropy_backward,
    cross_entropy_forward,
    divergence_backward,
    divergence_forward,
    mlp_backward,
    mlp_forward,
    sample_backward,
    sample_forward,
    sigmoid,
)

#: Version of the saved file's content.
_FORMAT = 1


@dataclasses.dataclass(frozen=True)
class Loss:
    """Loss of a batch, nats per picture.

    Attributes
    ----------
    cross_entropy, divergence : float
        The two terms; their sum is the loss.
    """

    cross_entropy: float
    divergence: float

    @property
    def total(self) -> float:
        """The loss."""
        return self.cross_entropy + self.divergence


@dataclasses.dataclass(frozen=True)
class Vae:
    """A variational autoencoder.

    Attributes
    ----------
    size : (int, int)
        Height and width of the pictures, px.
    hidden : tuple of int
        Units of the encoder's hidden layers; the decoder has them in reverse.
    num_latents : int
        Number of latents of a picture, Z.
    parameters : (P,) float64
        Weights and bias of each layer, encoder first.
    """

    size: tuple[int, int]
    hidden: tuple[int, ...]
    num_latents: int
    parameters: FloatArray = dataclasses.field(repr=False)

    def __post_init__(self) -> None:
        wanted = sum((given + 1) * units for given, units in self._shapes)
        if self.parameters.shape != (wanted,):
            raise ValueError(f"parameters: shape {self.parameters.shape}, wanted {(wanted,)}")
        if not np.isfinite(self.parameters).all():
            raise ValueError("parameters: some are not finite")

    @classmethod
    def start(cls, size: tuple[int, int], hidden: tuple[int, ...], num_latents: int, rng: np.random.Generator) -> Vae:
        """Return an untrained model: weights from N(0, 1 / inputs), so that sums keep about unit size, and bias 0."""
        shapes = _shapes(size, hidden, num_latents)
        parts = []
        for given, units in shapes:
            parts += [rng.normal(scale=given**-0.5, size=given * units), np.zeros(units)]
        return cls(size, hidden, num_latents, np.concatenate(parts))

    @property
    def _shapes(self) -> list[tuple[int, int]]:
        return _shapes(self.size, self.hidden, self.num_latents)

    def _layers(self) -> tuple[list[Dense], list[Dense]]:
        """Return views of the parameters: the layers of the encoder, and those of the decoder."""
        layers, start = [], 0
        for given, units in self._shapes:
            middle, end = start + given * units, start + (given + 1) * units
            layers.append((self.parameters[start:middle].reshape(given, units), self.parameters[middle:end]))
            start = end
        half = len(layers) // 2
        return layers[:half], layers[half:]

    def encode(self, images: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return mean and log variance of the latents of pictures (B, H, W) in [0, 1]; both (B, Z)."""
        return _halves(mlp_forward(self._pixels(images), self._layers()[0])[0])

    def decode(self, latents: ArrayLike) -> FloatArray:
        """Return the pictures (B, H, W), in [0, 1], of latents (B, Z)."""
        z = np.asarray(latents, np.float64)
        if z.ndim != 2 or z.shape[1] != self.num_latents:
            raise ValueError(f"latents: shape {z.shape}, wanted (B, {self.num_latents})")
        return sigmoid(mlp_forward(z, self._layers()[1])[0]).reshape(-1, *self.size)

    def loss_and_gradient(self, images: ArrayLike, noise: ArrayLike) -> tuple[Loss, FloatArray]:
        """Return the loss of pictures, and its gradient.

        Parameters
        ----------
        images : (B, H, W) array_like
            Grey in [0, 1].
        noise : (B, Z) array_like
            Noise of the reparameterization, from N(0, 1).

        Returns
        -------
        (Loss, (P,) float64)
            Nats per picture, and nats per picture and unit of each parameter.
        """
        pixels, noise = self._pixels(images), np.asarray(noise, np.float64)
        if noise.shape != (len(pixels), self.num_latents):
            raise ValueError(f"noise: shape {noise.shape}, wanted {(len(pixels), self.num_latents)}")
        encoder, decoder = self._layers()
        code, kept_encoder = mlp_forward(pixels, encoder)
        mean, log_variance = _halves(code)
        logits, kept_decoder = mlp_forward(sample_forward(mean, log_variance, noise), decoder)
        loss = Loss(cross_entropy_forward(logits, pixels), divergence_forward(mean, log_variance))

        # The latents affect the loss through the pixels and through the divergence: their gradients add up.
        d_z, d_decoder = mlp_backward(cross_entropy_backward(logits, pixels), kept_decoder, decoder)
        by_pixels = sample_backward(d_z, log_variance, noise)
        by_divergence = divergence_backward(mean, log_variance)
        d_code = np.concatenate([a + b for a, b in zip(by_pixels, by_divergence, strict=True)], axis=1)
        _, d_encoder = mlp_backward(d_code, kept_encoder, encoder)
        return loss, np.concatenate([part.ravel() for layer in (*d_encoder, *d_decoder) for part in layer])

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the model as ``.npz``, replacing an existing file atomically."""
        buffer = io.BytesIO()
        np.savez(
            buffer,
            parameters=self.parameters,
            format=np.array(_FORMAT),
            size=np.array(self.size),
            hidden=np.array(self.hidden),
            num_latents=np.array(self.num_latents),
        )
        write_atomically(path, buffer.getvalue())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Vae:
        """Read a model that :meth:`save` wrote.

        Raises
        ------
        LiveclError
            If the file is not one.
        """
        try:
            if not zipfile.is_zipfile(path):
                raise ValueError("it is missing or no complete .npz file")
            with np.load(path, allow_pickle=False) as file:
                arrays = dict(file)
            if int(arrays["format"]) != _FORMAT:
                raise ValueError(f"format {arrays['format']}, wanted {_FORMAT}")
            height, width = map(int, arrays["size"])
            hidden = tuple(map(int, arrays["hidden"]))
            parameters = np.asarray(arrays["parameters"], np.float64)
            return cls((height, width), hidden, int(arrays["num_latents"]), parameters)
        except Exception as error:  # damaged archives can raise any exception
            raise LiveclError(f"{os.fspath(path)!r} is not a saved VAE: {error}") from error

    def _pixels(self, images: ArrayLike) -> FloatArray:
        """Return pictures as rows, (B, D)."""
        pixels = np.asarray(images, np.float64)
        if pixels.ndim != 3 or pixels.shape[1:] != tuple(self.size) or not len(pixels):
            raise ValueError(f"images: shape {pixels.shape}, wanted (B, {self.size[0]}, {self.size[1]})")
        if not (pixels.min() >= 0 and pixels.max() <= 1):
            raise ValueError(f"images: from {pixels.min():g} to {pixels.max():g}, wanted within [0, 1]")
        return pixels.reshape(len(pixels), -1)


def interpolate_latents(model: Vae, a: ArrayLike, b: ArrayLike, count: int) -> FloatArray:
    """Interpolate between two pictures in the latent space.

    Parameters
    ----------
    model : Vae
        A trained model.
    a, b : (H, W) array_like
        First and last picture, in [0, 1].
    count : int
        Number of pictures, the model's reconstructions of `a` and `b` included.

    Returns
    -------
    (count, H, W) float64
        The decoded latents ``(1 - t) mean_a + t mean_b``, t from 0 to 1 in even steps.

    Notes
    -----
    Linear, as in the paper, not along a great circle: that keeps the length of *samples* of N(0, 1), which in many
    dimensions lie near a sphere. The encoder's means do not, nor do samples of about ten latents; and four corners can
    only be blended linearly.
    """
    if count < 2:
        raise ValueError(f"count: got {count}, wanted at least 2")
    ends = model.encode(np.stack([np.asarray(a), np.asarray(b)]))[0]
    t = np.linspace(0, 1, count)[:, None]
    return model.decode((1 - t) * ends[0] + t * ends[1])


def latent_grid(model: Vae, corners: ArrayLike, rows: int, columns: int) -> FloatArray:
    """Interpolate bilinearly between four pictures in the latent space.

    Parameters
    ----------
    model : Vae
        A trained model.
    corners : (4, H, W) array_like
        Pictures in the corners: top left, top right, bottom left, bottom right.
    rows, columns : int
        Size of the grid, the model's reconstructions of the corners included.

    Returns
    -------
    (rows, columns, H, W) float64
        The decoded latents.
    """
    for name, value in (("rows", rows), ("columns", columns)):
        if value < 2:
            raise ValueError(f"{name}: got {value}, wanted at least 2")
    means = model.encode(corners)[0]
    if len(means) != 4:
        raise ValueError(f"corners: {len(means)} pictures, wanted 4")
    down, across = np.linspace(0, 1, rows), np.linspace(0, 1, columns)
    vertical, horizontal = np.stack([1 - down, down]), np.stack([1 - across, across])
    latents = np.einsum("ir,jc,ijz->rcz", vertical, horizontal, means.reshape(2, 2, -1))
    return model.decode(latents.reshape(rows * columns, -1)).reshape(rows, columns, *model.size)


def _shapes(size: tuple[int, int], hidden: tuple[int, ...], num_latents: int) -> list[tuple[int, int]]:
    """Return numbers of inputs and outputs of each layer; the encoder's last has mean and log variance as outputs."""
    for name, values in (("size", size), ("hidden", hidden), ("num_latents", (num_latents,))):
        if not all(value >= 1 for value in values):
            raise ValueError(f"{name}: got {', '.join(map(str, values))}, wanted numbers of at least 1")
    pixels = size[0] * size[1]
    encoder = pairwise((pixels, *hidden, 2 * num_latents))
    decoder = pairwise((num_latents, *reversed(hidden), pixels))
    return [*encoder, *decoder]


def _halves(code: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Split the encoder's output (B, 2 Z) into mean and log variance, (B, Z) each."""
    half = code.shape[1] // 2
    return code[:, :half], code[:, half:]
