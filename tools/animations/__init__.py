# SPDX-License-Identifier: Apache-2.0
"""What the tools share that write drawings one after the other."""
