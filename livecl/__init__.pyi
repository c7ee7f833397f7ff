# SPDX-License-Identifier: Apache-2.0
from .batch import vectorize_files as vectorize_files
from .drawing import Drawing as Drawing
from .errors import CheckpointError as CheckpointError
from .errors import DeviceError as DeviceError
from .errors import DeviceMemoryError as DeviceMemoryError
from .errors import ImageError as ImageError
from .errors import KernelBuildError as KernelBuildError
from .errors import LiveclError as LiveclError
from .errors import SvgError as SvgError
from .image import read_image as read_image
from .interpolation import interpolate as interpolate
from .opencl import list_devices as list_devices
from .options import Options as Options
from .rendering import Gradients as Gradients
from .rendering import Rasterizer as Rasterizer
from .rendering import render as render
from .run import Control as Control
from .run import Recipe as Recipe
from .run import Result as Result
from .run import RunError as RunError
from .run import SequenceResult as SequenceResult
from .run import Step as Step
from .run import vectorize as vectorize
from .run import vectorize_sequence as vectorize_sequence
from .svg import read_svg as read_svg
from .version import __version__ as __version__

__all__ = [
    "CheckpointError",
    "Control",
    "DeviceError",
    "DeviceMemoryError",
    "Drawing",
    "Gradients",
    "ImageError",
    "KernelBuildError",
    "LiveclError",
    "Options",
    "Rasterizer",
    "Recipe",
    "Result",
    "RunError",
    "SequenceResult",
    "Step",
    "SvgError",
    "interpolate",
    "list_devices",
    "read_image",
    "read_svg",
    "render",
    "vectorize",
    "vectorize_files",
    "vectorize_sequence",
]
