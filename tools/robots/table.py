"""Compares the chain that is taken for the arm with the expected one: `table.py DIRECTORY PROGRAM [--table]`."""
import fnmatch
import json
import subprocess
import sys
from pathlib import Path

ROOT, PROGRAM = Path(sys.argv[1]), sys.argv[2]
FULL = '--table' in sys.argv
EXPECTED = Path(__file__).with_name('expected.txt')


def rows():
    """Pattern of the file name, and the expected arms (`last joint: tip`) or why the file is not counted."""
    for line in EXPECTED.read_text().splitlines():
        if line.strip() and not line.startswith('#'):
            pattern, _, rest = line.partition(' ')
            yield pattern, rest.strip()


def expected(name):
    found = [rest for pattern, rest in rows() if fnmatch.fnmatch(name, pattern)]
    if not found:
        raise SystemExit(f'{name}: no row of {EXPECTED} says where its arm ends')
    return found[0]


def verdict(answer, arms):
    if 'error' in answer:
        return 'refused: ' + answer['error']
    got = {(arm['joints'][-1], arm['tip']) for arm in answer['arms']}
    if got == arms:
        return 'right'
    return 'wrong: ' + ', '.join(f'{joint}:{tip}' for joint, tip in sorted(got))


def main():
    files = sorted(path for path in ROOT.rglob('*.urdf'))
    names = {str(path): str(path.relative_to(ROOT)) for path in files}
    expectations = {path: expected(name) for path, name in names.items()}
    counted = [path for path in names if not expectations[path].startswith('-')]
    output = subprocess.run([PROGRAM, *counted], check=True, capture_output=True, text=True).stdout
    right = 0
    for line in output.splitlines():
        answer = json.loads(line)
        arms = {tuple(arm.split(':')) for arm in expectations[answer['file']].split()}
        said = verdict(answer, arms)
        right += said == 'right'
        if FULL or said != 'right':
            print(names[answer['file']], said, sep='\n  ')
        if FULL:
            for arm in answer.get('arms', []):
                print(f'  {arm["base"]} → {arm["tip"]}: {", ".join(arm["joints"])}')
                print(f'    left out: {", ".join(arm["left_out"]) or "nothing"}')
    print(f'{right} of {len(counted)} right at once; {len(names) - len(counted)} files are not of arms')


main()
