"""What all figures share; matplotlib is imported where something is drawn."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: From the palette of Okabe and Ito; other classes are grey.
COLOURS = ["#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#f0e442"]
REST = "#999999"


def new_axes(axes: Any = None) -> Any:
    """The axes given, or new ones."""
    if axes is not None:
        return axes
    try:
        import matplotlib.pyplot as plt  # type: ignore[import-not-found,unused-ignore]
    except ImportError as error:
        raise ImportError("figures need matplotlib: pip install 'stickslip[plot]'") from error
    return plt.subplots()[1]


def classes(axes: Any, x: Any, y: Any, numbers: NDArray[np.int64], names: Sequence[str]) -> None:
    """Cells of a grid, or points where `x` and `y` are as many, coloured by their class."""
    from matplotlib.colors import ListedColormap  # type: ignore[import-not-found,unused-ignore]
    from matplotlib.patches import Patch  # type: ignore[import-not-found,unused-ignore]

    colours = [COLOURS[k] if k < len(COLOURS) else REST for k in range(len(names))]
    style: dict[str, Any] = {
        "cmap": ListedColormap(["white", *colours]),
        "vmin": -1.5,
        "vmax": len(names) - 0.5,
    }
    if numbers.ndim == 2:
        axes.pcolormesh(x, y, numbers, shading="nearest", **style)
    else:
        axes.scatter(x, y, c=numbers, s=4, **style)
    patches = [Patch(color=colour, label=name) for colour, name in zip(colours, names)]
    axes.legend(handles=patches, loc="upper left", bbox_to_anchor=(1.0, 1.0))
