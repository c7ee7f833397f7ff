# SPDX-License-Identifier: Apache-2.0
from .center_lines import LineScores as LineScores
from .center_lines import score_lines as score_lines
from .colors import color_difference as color_difference
from .colors import colors_in_picture as colors_in_picture
from .colors import main_colors as main_colors
from .disturbances import DISTURBANCES as DISTURBANCES
from .disturbances import disturbed as disturbed
from .layers import LayerMeasures as LayerMeasures
from .layers import measure_layers as measure_layers
from .layers import num_parameters as num_parameters
from .layers import self_crossing as self_crossing
from .numbers import count_numbers as count_numbers
from .outlines import OutlineScores as OutlineScores
from .outlines import score_outlines as score_outlines
from .outlines_sheet import draw_outlines as draw_outlines
from .pictures import mse as mse
from .pictures import psnr as psnr
from .pictures import ssim as ssim
from .things import Things as Things
from .things import ThingScores as ThingScores
from .things import match_things as match_things
from .things import score_drawing as score_drawing
from .things import score_things as score_things
from .things import things_of_drawing as things_of_drawing
from .things_sheet import draw_things as draw_things

__all__ = [
    "DISTURBANCES",
    "LayerMeasures",
    "LineScores",
    "OutlineScores",
    "ThingScores",
    "Things",
    "color_difference",
    "colors_in_picture",
    "count_numbers",
    "disturbed",
    "draw_outlines",
    "draw_things",
    "main_colors",
    "match_things",
    "measure_layers",
    "mse",
    "num_parameters",
    "psnr",
    "score_drawing",
    "score_lines",
    "score_outlines",
    "score_things",
    "self_crossing",
    "ssim",
    "things_of_drawing",
]
