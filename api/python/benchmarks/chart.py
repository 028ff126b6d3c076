"""Draws the column "one step" of the comparison in README.md as bars.

Usage, in the folder of the repository: `python api/python/benchmarks/chart.py README.md docs/performance/steps.svg`.
"""

import re
import sys
from pathlib import Path

ROW = re.compile(r"^\| \[?([A-Za-z]+)\]?.*\| \[([\d.]+)\]\([^|]*\) \|$", re.MULTILINE)
LEFT, WIDTH, HEIGHT, TOP = 100, 580, 26, 40


def chart(page: str) -> str:
    """Returns the picture."""
    rows = sorted((float(ratio), name) for name, ratio in ROW.findall(page))
    height = TOP + HEIGHT * len(rows) + 10
    font = 'font-family="sans-serif" font-size="14"'
    svg = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 760 {height}" {font}>\n'
    svg += "<title>Median time of one control period in Python, relative to revprio</title>\n"
    svg += f'<rect width="760" height="{height}" fill="#fff"/>\n'
    svg += f'<text x="{LEFT}" y="22">median time of one control period in Python, relative to revprio</text>\n'
    for k, (ratio, name) in enumerate(rows):
        y, width = TOP + HEIGHT * k, WIDTH * ratio / rows[-1][0]
        colour = "#d55e00" if name == "revprio" else "#8c9aa6"
        svg += f'<rect x="{LEFT}" y="{y}" width="{width:.1f}" height="{HEIGHT - 8}" fill="{colour}"/>\n'
        svg += f'<text x="{LEFT - 8}" y="{y + 14}" text-anchor="end">{name}</text>\n'
        svg += f'<text x="{LEFT + width + 6:.1f}" y="{y + 14}">{ratio:g}</text>\n'
    return svg + "</svg>\n"


if __name__ == "__main__":
    source, target = map(Path, sys.argv[1:])
    target.write_text(chart(source.read_text(encoding="utf-8")), encoding="utf-8")
