# SPDX-License-Identifier: Apache-2.0
"""Conditional processing of SVG: whether an element is shown, to a reader of English without extensions."""

from __future__ import annotations

from xml.etree.ElementTree import Element

#: Feature strings of SVG 1.1 and SVG Tiny 1.2, and the modules of them that a static picture has.
_FEATURES = ("http://www.w3.org/TR/SVG11/feature#", "http://www.w3.org/Graphics/SVG/feature/1.2/#")
_MODULES = {
    *("SVG", "SVG-static", "CoreAttribute", "Structure", "BasicStructure", "ContainerAttribute", "Extensibility"),
    *("ConditionalProcessing", "ConditionalProcessingAttribute", "Image", "Style", "ViewportAttribute", "Shape"),
    *("Text", "BasicText", "PaintAttribute", "BasicPaintAttribute", "OpacityAttribute", "GraphicsAttribute"),
    *("BasicGraphicsAttribute", "Marker", "ColorProfile", "Gradient", "Pattern", "Clip", "BasicClip", "Mask"),
    *("Filter", "BasicFilter", "Hyperlinking", "XlinkAttribute", "View", "Font", "BasicFont", "SolidColor"),
    "ExternalResourcesRequired",
}


def is_shown(element: Element) -> bool:
    """Return whether an element's ``systemLanguage``, ``requiredFeatures`` and ``requiredExtensions`` all hold."""
    languages = element.get("systemLanguage")
    if languages is not None and not any(
        language.strip().lower().partition("-")[0] == "en" for language in languages.split(",")
    ):
        return False
    features = element.get("requiredFeatures")
    if features is not None and not (features.split() and all(_is_known(feature) for feature in features.split())):
        return False
    return element.get("requiredExtensions") is None


def _is_known(feature: str) -> bool:
    if feature in ("org.w3c.svg", "org.w3c.svg.static"):  # SVG 1.0
        return True
    return any(feature.startswith(start) and feature[len(start) :] in _MODULES for start in _FEATURES)
