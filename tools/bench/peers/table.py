"""Prints the results of the peers as a Markdown table, grouped and sorted by time: python table.py LINES [DOCUMENT]."""
import re
import sys
from pathlib import Path


def seconds(value):
    for unit, factor in (('ns', 1e9), ('µs', 1e6), ('ms', 1e3)):
        if value * factor < 1000:
            return f'{value * factor:.3g} {unit}'
    return f'{value:.3g} s'


fastest, remarks = {}, {}
for line in Path(sys.argv[1]).read_text().splitlines():
    # Names can contain commas; the four numbers cannot, and errors can be missing.
    cells = re.fullmatch(r'(.+),([0-9.e+-]+),([0-9.e+-]+),([^,]*),([^,]*)', line)
    if not cells:
        # Other rounds have the same remarks, and the same program compiled otherwise computes the same numbers.
        remarks.setdefault(line.replace(' (native)', ''))
        continue
    name, median, p99, error, first = cells.groups()
    row = (name.split(':')[0].split(',')[0], float(median), name, float(p99), error, first)
    fastest[name] = min(fastest.get(name, row), row, key=lambda row: row[1])
rows = list(fastest.values())
groups = list(dict.fromkeys(row[0] for row in rows))
rows.sort(key=lambda row: (groups.index(row[0]), row[1]))


def base(group, is_cold):
    """The row of revprio that others are compared with: the way that a control loop takes, or a cold one."""
    ours = [row for row in rows if row[0] == group and ': revprio' in row[2] and '(native)' not in row[2]]
    start = 'cold' if is_cold else 'warm'
    return min(ours, key=lambda row: (not row[2].endswith(start), not row[2].endswith('auto'), row[1]))


table = '| program | median | p99 | median × revprio | p99 × revprio | error of q̇, rad/s | error of task 1, m/s |\n'
table += '| --- | ---: | ---: | ---: | ---: | ---: | ---: |\n'
for group, median, name, p99, error, first in rows:
    own = base(group, name.endswith('cold'))
    ratios = f'{median / own[1]:.2f} | {p99 / own[3]:.2f}'
    table += f'| {name} | {seconds(median)} | {seconds(p99)} | {ratios} | {error} | {first} |\n'
table += ''.join(f'\n{remark}\n' for remark in remarks)
print(table)
if len(sys.argv) > 2:
    document = Path(sys.argv[2])
    mark = re.compile(r'(<!-- bench:peers -->\n).*?(<!-- end -->)', re.DOTALL)
    document.write_text(mark.sub(lambda match: f'{match[1]}\n{table}\n{match[2]}', document.read_text()))
