"""Parts that all figures share. matplotlib is imported when something is drawn."""

from __future__ import annotations

import colorsys
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: The palette of Okabe and Ito, and three further colours.
COLOURS = [
    *("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#f0e442"),
    *("#882255", "#b0d88a", "#5d3a1a"),
]
#: Colours of outcomes that are no attractor.
GREYS = {"undecided": "#d4d4d4", "escape": "#9a9a9a", "end": "#6a6a6a", "failure": "#303030"}
#: A legend with more classes or longer names would leave no room for the figure.
MOST_IN_LEGEND = 12
LONGEST_NAME = 34


def new_axes(axes: Any = None) -> Any:
    """The axes given, or those of a new figure, whose layout leaves room for a legend below."""
    if axes is not None:
        return _single(axes)
    try:
        import matplotlib.pyplot as plt  # type: ignore[import-not-found,unused-ignore]
    except ImportError as error:
        raise ImportError("figures need matplotlib: pip install 'stickslip[plot]'") from error
    return plt.subplots(layout="constrained")[1]


def _single(axes: Any) -> Any:
    """The axes, if they are one Axes of matplotlib."""
    if hasattr(axes, "plot") and hasattr(axes, "axvspan"):
        return axes
    many = list(np.ravel(axes)) if isinstance(axes, (np.ndarray, list, tuple)) else []
    if len(many) == 1:
        return _single(many[0])
    if many and all(hasattr(one, "axvspan") for one in many):
        first = "axes[0, 0]" if np.ndim(axes) == 2 else "axes[0]"
        raise TypeError(f"axes are {len(many)}, and this figure has one: give one, as {first}")
    raise TypeError(f"axes must be an Axes of matplotlib, as plt.subplots()[1], not {axes!r}")


def several_axes(axes: Any, count: int, what: str) -> Any:
    """Axes of the given number, in a row; `what` says what they show."""
    many = list(np.ravel(axes)) if isinstance(axes, (np.ndarray, list, tuple)) else [axes]
    if len(many) != count:
        raise ValueError(
            f"axes are {len(many)}, and this figure has {count}, {what}: give "
            f"plt.subplots({count})[1]"
        )
    return np.array([_single(one) for one in many], dtype=object)


def colours_of(names: Sequence[str]) -> list[Any]:
    """A colour for each class: a grey by the first word of its name, or the next colour."""
    greys = [next((GREYS[word] for word in GREYS if one.startswith(word)), None) for one in names]
    return [grey or _colour(greys[:k].count(None)) for k, grey in enumerate(greys)]


def _colour(k: int) -> Any:
    if k < len(COLOURS):
        return COLOURS[k]
    # Hues a golden section apart, dark and light in turn.
    return colorsys.hls_to_rgb(k * 0.618 % 1.0, 0.3 + 0.35 * (k % 2), 0.7)


def draw_classes(
    axes: Any,
    x: Any,
    y: Any,
    numbers: NDArray[np.int64],
    names: Sequence[str],
    others: Sequence[Any] = (),
) -> None:
    """Draws cells of a grid, or points, coloured by class. The legend below also lists `others`,
    which are drawn already."""
    from matplotlib.colors import ListedColormap  # type: ignore[import-not-found,unused-ignore]
    from matplotlib.patches import Patch  # type: ignore[import-not-found,unused-ignore]

    colours = colours_of(names)
    style: dict[str, Any] = {
        "cmap": ListedColormap(["white", *colours]),
        "vmin": -1.5,
        "vmax": len(names) - 0.5,
    }
    if numbers.ndim == 2:
        axes.pcolormesh(x, y, numbers, shading="nearest", **style)
    else:
        axes.scatter(x, y, c=numbers, s=4, **style)
    few = len(names) if len(names) <= MOST_IN_LEGEND else MOST_IN_LEGEND - 1
    labels = [
        name if len(name) <= LONGEST_NAME else name[: LONGEST_NAME - 1] + "…"
        for name in names[:few]
    ]
    patches = [Patch(color=colour, label=label) for colour, label in zip(colours, labels)]
    if few < len(names):
        patches.append(Patch(color="none", label=f"and {len(names) - few} more"))
    longest = max(map(len, labels), default=0)
    axes.legend(
        handles=[*patches, *others],
        loc="upper center",
        bbox_to_anchor=(0.5, 0.0),
        # In font sizes: below the numbers and the label of the axis.
        borderaxespad=5,
        fontsize="small",
        ncols=min(3, 84 // (longest + 8)),
        frameon=False,
    )
