# SPDX-License-Identifier: Apache-2.0
"""Labels by known values: components of a relation between neighbours, means."""

from __future__ import annotations

import numpy as np

from livecl.layering.segmentation.labels import equal_components, grid_components, means_of, with_blocks


def test_means_of_labels() -> None:
    labels = np.array([[0, 1, 1], [3, 3, 1]])
    image = np.arange(6.0).reshape(2, 3, 1)
    np.testing.assert_allclose(means_of(labels, image), [[0], [8 / 3], [0], [3.5]])


def test_components_are_joined_by_what_holds_between_neighbours() -> None:
    right, down = np.array([[True, False], [False, True]]), np.array([[False, False, True]])
    labels = grid_components(right, down)
    assert labels[0, 0] == labels[0, 1] and labels[1, 1] == labels[1, 2] == labels[0, 2]
    assert len(np.unique(labels)) == 3
    assert labels.ravel()[0] == 0 and (np.diff(np.unique(labels, return_index=True)[1]) > 0).all()


def test_equal_neighbours_on_all_eight_sides_are_joined() -> None:
    labels = np.array([[0, 5, 7], [5, 0, 7], [5, 5, 0]])
    np.testing.assert_array_equal(equal_components(labels), [[0, 1, 2], [1, 0, 2], [1, 1, 0]])


def test_labels_without_a_block_of_four_pixels_become_0_and_the_others_are_numbered_in_order() -> None:
    labels = np.array([[4, 4, 2, 0], [4, 4, 2, 1], [3, 3, 1, 1], [3, 3, 1, 1]])
    np.testing.assert_array_equal(with_blocks(labels), [[3, 3, 0, 0], [3, 3, 0, 1], [2, 2, 1, 1], [2, 2, 1, 1]])
