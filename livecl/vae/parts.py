# SPDX-License-Identifier: Apache-2.0
"""Parts of a variational autoencoder: the forward of each, and below it its hand-derived backward.

A batch has B pictures of D pixels. ``d_x`` stands for dL/dx, an array shaped like x.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from livecl.arrays import FloatArray

#: Weights (I, O) and bias (O,) of a dense layer.
Dense = tuple[FloatArray, FloatArray]


def dense_forward(x: FloatArray, weights: FloatArray, bias: FloatArray) -> FloatArray:
    """Return y = x W + b, (B, O), of x (B, I)."""
    return x @ weights + bias


def dense_backward(d_y: FloatArray, x: FloatArray, weights: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return d_x, d_weights, d_bias.

    From y_bo = sum_i x_bi W_io + b_o,

        d_x_bi = sum_o d_y_bo W_io        d_W_io = sum_b x_bi d_y_bo        d_b_o = sum_b d_y_bo
    """
    return d_y @ weights.T, x.T @ d_y, d_y.sum(axis=0)


def sigmoid(x: FloatArray) -> FloatArray:
    """Return 1 / (1 + exp(-x)), by the hyperbolic tangent, which does not overflow."""
    return 0.5 + 0.5 * np.tanh(0.5 * x)


def silu_forward(x: FloatArray) -> FloatArray:
    """Return y = x sigmoid(x): like a rectifier, but smooth."""
    return x * sigmoid(x)


def silu_backward(d_y: FloatArray, x: FloatArray) -> FloatArray:
    """Return d_x.

    With s = sigmoid(x), ds/dx = s (1 - s), so dy/dx = s + x s (1 - s).
    """
    s = sigmoid(x)
    return d_y * s * (1 + x * (1 - s))


def mlp_forward(x: FloatArray, layers: Sequence[Dense]) -> tuple[FloatArray, list[FloatArray]]:
    """Run dense layers with a SiLU between each two.

    Returns
    -------
    ((B, O), list of (B, I))
        The last layer's y, and for the backward the input of each layer before its SiLU (the first one's is x itself).
    """
    given = [x]
    y = dense_forward(x, *layers[0])
    for layer in layers[1:]:
        given.append(y)
        y = dense_forward(silu_forward(y), *layer)
    return y, given


def mlp_backward(
    d_y: FloatArray, given: Sequence[FloatArray], layers: Sequence[Dense]
) -> tuple[FloatArray, list[Dense]]:
    """Return d_x, and d_weights and d_bias of each layer: the chain rule, from the last layer to the first."""
    d_layers: list[Dense] = []
    for index in range(len(layers) - 1, 0, -1):
        d_h, d_weights, d_bias = dense_backward(d_y, silu_forward(given[index]), layers[index][0])
        d_layers.append((d_weights, d_bias))
        d_y = silu_backward(d_h, given[index])
    d_x, d_weights, d_bias = dense_backward(d_y, given[0], layers[0][0])
    return d_x, [(d_weights, d_bias), *reversed(d_layers)]


def sample_forward(mean: FloatArray, log_variance: FloatArray, noise: FloatArray) -> FloatArray:
    """Return z = mean + exp(log_variance / 2) noise, the latents; all (B, Z), the noise from N(0, 1)."""
    return mean + np.exp(0.5 * log_variance) * noise


def sample_backward(d_z: FloatArray, log_variance: FloatArray, noise: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return d_mean, d_log_variance.

    The noise is a constant, so dz/dmean = 1 and dz/dlog_variance = exp(log_variance / 2) noise / 2.
    """
    return d_z, d_z * 0.5 * np.exp(0.5 * log_variance) * noise


def divergence_forward(mean: FloatArray, log_variance: FloatArray) -> float:
    """Return KL(N(mean, exp(log_variance)) || N(0, 1)) in nats, the mean over B of the sum over Z.

    Of two Gaussians it has the closed form (mean^2 + exp(log_variance) - 1 - log_variance) / 2.
    """
    nats = 0.5 * (mean * mean + np.exp(log_variance) - 1 - log_variance)
    return float(nats.sum() / len(mean))


def divergence_backward(mean: FloatArray, log_variance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return d_mean = mean / B, d_log_variance = (exp(log_variance) - 1) / 2B of the divergence itself."""
    return mean / len(mean), 0.5 * (np.exp(log_variance) - 1) / len(mean)


def cross_entropy_forward(logits: FloatArray, pixels: FloatArray) -> float:
    """Return the cross-entropy of pixels x in [0, 1] and Bernoulli logits l, nats, the mean over B of the sum over D.

    -x log s(l) - (1 - x) log(1 - s(l)) = log(1 + exp(l)) - x l, with s the sigmoid, and
    log(1 + exp(l)) = max(l, 0) + log(1 + exp(-|l|)), which does not overflow.
    """
    nats = np.maximum(logits, 0) + np.log1p(np.exp(-np.abs(logits))) - pixels * logits
    return float(nats.sum() / len(logits))


def cross_entropy_backward(logits: FloatArray, pixels: FloatArray) -> FloatArray:
    """Return d_logits = (sigmoid(l) - x) / B of the cross-entropy itself, since d log(1 + exp(l)) / dl = s(l)."""
    return (sigmoid(logits) - pixels) / len(logits)
