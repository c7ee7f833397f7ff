# SPDX-License-Identifier: Apache-2.0
from .course import Course as Course
from .notebook import LiveView as LiveView
from .report import write_report as write_report
from .sheet import save_plot as save_plot
from .sheet import save_sheet as save_sheet

__all__ = [
    "Course",
    "LiveView",
    "save_plot",
    "save_sheet",
    "write_report",
]
