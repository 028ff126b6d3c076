"""Prints the results of the peers as a Markdown table, grouped and sorted by time: python table.py LINES [DOCUMENT]."""
import re
import sys
from pathlib import Path


def seconds(value):
    for unit, factor in (('ns', 1e9), ('µs', 1e6), ('ms', 1e3)):
        if value * factor < 1000:
            return f'{value * factor:.3g} {unit}'
    return f'{value:.3g} s'


rows, remarks = [], []
for line in Path(sys.argv[1]).read_text().splitlines():
    cells = line.split(',')
    if len(cells) < 5:
        remarks.append(line)
        continue
    # Names can contain commas; the four numbers cannot.
    name, (median, p99, error, first) = ','.join(cells[:-4]), cells[-4:]
    rows.append((name.split(':')[0].split(',')[0], float(median), name, float(p99), error, first))
groups = list(dict.fromkeys(row[0] for row in rows))
rows.sort(key=lambda row: (groups.index(row[0]), row[1]))
revprio = {group: min(row[1] for row in rows if row[0] == group and 'revprio' in row[2]) for group in groups}
table = '| program | median | p99 | × revprio | error of q̇, rad/s | error of task 1, m/s |\n'
table += '| --- | ---: | ---: | ---: | ---: | ---: |\n'
for group, median, name, p99, error, first in rows:
    table += f'| {name} | {seconds(median)} | {seconds(p99)} | {median / revprio[group]:.2f} | {error} | {first} |\n'
table += ''.join(f'\n{remark}\n' for remark in remarks)
print(table)
if len(sys.argv) > 2:
    document = Path(sys.argv[2])
    mark = re.compile(r'(<!-- bench:peers -->\n).*?(<!-- end -->)', re.DOTALL)
    document.write_text(mark.sub(lambda match: f'{match[1]}\n{table}\n{match[2]}', document.read_text()))
