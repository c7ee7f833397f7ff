# SPDX-License-Identifier: Apache-2.0
from .model import Vae as Vae
from .model import interpolate_latents as interpolate_latents
from .training import train_vae as train_vae

__all__ = [
    "Vae",
    "interpolate_latents",
    "train_vae",
]
