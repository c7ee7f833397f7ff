# SPDX-License-Identifier: Apache-2.0
from .layers import LayerMeasures as LayerMeasures
from .layers import measure_layers as measure_layers
from .layers import num_parameters as num_parameters
from .layers import self_crossing as self_crossing
from .pictures import mse as mse
from .pictures import psnr as psnr
from .pictures import ssim as ssim

__all__ = [
    "LayerMeasures",
    "measure_layers",
    "mse",
    "num_parameters",
    "psnr",
    "self_crossing",
    "ssim",
]
