"""The sheet that pictures are drawn on: panels side by side and one colour bar, laid out in inches so that every frame of
a run has the same layout."""
import textwrap

from matplotlib.figure import Figure

from .drawing import INK, WARNING

LEFT, TOP, BOTTOM, BETWEEN = 0.22, 0.62, 0.4, 0.35
BAR_GAP, BAR_WIDTH, BAR_LABELS = 0.14, 0.16, 0.72
WIDEST, TALLEST, NARROWEST = 5.0, 5.2, 3.6  # size of a panel (inches)


class PanelLayout:
    """Creates the sheet. `sizes`: width and height of each panel, in any unit."""

    def __init__(self, sizes, with_bar):
        widest = WIDEST if len(sizes) == 1 else 4.2
        panels = [fitted(size, widest) for size in sizes]
        height = max(h for _, h in panels)
        columns = [max(w, NARROWEST) for w, _ in panels]
        right = BAR_GAP + BAR_WIDTH + BAR_LABELS if with_bar else LEFT
        self.width = LEFT + sum(columns) + BETWEEN * (len(columns) - 1) + right
        self.height = BOTTOM + height + TOP
        self.figure = Figure(figsize=(self.width, self.height))
        self.panels, self.columns = [], []
        left = LEFT
        for (w, h), column in zip(panels, columns):
            rectangle = [left + (column - w) / 2, BOTTOM + (height - h) / 2, w, h]
            self.panels.append(self.figure.add_axes(self.figure_fractions(rectangle)))
            self.columns.append((left, column, rectangle[1] + h))
            left += column + BETWEEN
        bar = [left - BETWEEN + BAR_GAP, BOTTOM + 0.06 * height, BAR_WIDTH, 0.88 * height]
        self.bar = self.figure_fractions(bar) if with_bar else None

    def figure_fractions(self, rectangle):
        left, bottom, w, h = rectangle
        return [left / self.width, bottom / self.height, w / self.width, h / self.height]

    def head(self, panel, title, caption, warning=""):
        """Draws lines of text above a panel, shortened to its width. Returns them, so that they can be removed."""
        left, column, top = self.columns[panel]
        lines = [(title, 10, 0.42), (caption, 8.5, 0.24), (warning, 8, 0.08)] if warning else [(title, 10, 0.3), (caption, 8.5, 0.1)]
        return [
            self.figure.text(
                (left + column / 2) / self.width,
                (top + above) / self.height,
                textwrap.shorten(words, int(column / (0.0072 * size)), placeholder=" …") if words else "",
                fontsize=size,
                color=WARNING if words is warning else INK,
                ha="center",
                va="bottom",
                parse_math=False,  # a $ in the title of a scene is not mathematics
            )
            for words, size, above in lines
        ]


def fitted(size, widest):
    scale = min(widest / size[0], TALLEST / size[1])
    return size[0] * scale, size[1] * scale
