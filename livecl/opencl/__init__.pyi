# SPDX-License-Identifier: Apache-2.0
from .device import list_devices as list_devices

__all__ = [
    "list_devices",
]
