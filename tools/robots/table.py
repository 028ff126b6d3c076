"""Compares the chain that is taken for the arm with the expected one: `table.py VENV PROGRAM [--table|--grippers]`."""
import fnmatch
import json
import subprocess
import sys
from pathlib import Path

import client
import mujoco_models

VENV, PROGRAM = Path(sys.argv[1]), sys.argv[2]
FULL = '--table' in sys.argv
EXPECTED = Path(__file__).with_name('expected.txt')
# URDF texts that are made from other files.
MADE = VENV.with_name('made')
# What a file contains that is a robot.
ROOTS = {'urdf': '', 'xacro': '<robot', 'xml': '<mujoco'}
# Largest difference from MuJoCo in position, m, and entries of the rotation.
MAX_DIFFERENCE = 1e-9


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


def files(ending):
    """The files that count, by name, and the number of others."""
    found = sorted(path for path in VENV.rglob(f'*.{ending}') if ROOTS[ending] in path.read_text(errors='replace'))
    names = {str(path.relative_to(VENV)).split('site-packages/')[-1]: path for path in found}
    counted = {name: path for name, path in names.items() if not expected(name).startswith('-')}
    return counted, len(names) - len(counted)


def expand(path, made):
    """Writes the URDF text of a xacro file. ROS packages are directories with almost the same name."""
    directories = [directory for directory in path.parents[2].rglob('*') if directory.is_dir()]
    packages = {directory.name.removesuffix('_description'): directory for directory in directories}
    packages |= {f'{directory.name}_support': directory for directory in directories}
    packages |= {directory.name: directory for directory in directories}
    made.parent.mkdir(parents=True, exist_ok=True)
    made.write_text(client.module('xacro').read_xacro(path, packages=packages))


def urdf(name, path):
    """The URDF file of a robot, or why there is none."""
    if path.suffix == '.urdf':
        return path, None
    made = MADE / f'{name}.urdf'
    try:
        (expand if path.suffix == '.xacro' else mujoco_models.convert)(path, made)
    except ValueError as error:
        return None, {'error': str(error)}
    return made, None


def answers(counted):
    """The answer for each file, by name."""
    texts = {name: urdf(name, path) for name, path in counted.items()}
    program = [PROGRAM, *(str(text) for text, error in texts.values() if error is None)]
    output = subprocess.run(program, check=True, capture_output=True, text=True).stdout
    answered = {answer['file']: answer for answer in map(json.loads, output.splitlines())}
    return {name: error or answered[str(text)] for name, (text, error) in texts.items()}


def verdict(name, path, answer):
    if 'error' in answer:
        return 'refused: ' + answer['error'].split('.urdf: ')[-1]
    got = {f'{arm["joints"][-1]}:{arm["tip"]}' for arm in answer['arms']}
    if got != set(expected(name).split()):
        return 'wrong: ' + ', '.join(sorted(got))
    is_mujoco = path.suffix == '.xml'
    difference = max(mujoco_models.error(path, arm) for arm in answer['arms']) if is_mujoco else 0.0
    return 'right' if difference <= MAX_DIFFERENCE else f'wrong: poses differ from MuJoCo by {difference:.1e}'


def show(answer):
    for arm in answer.get('arms', []):
        print(f'  {arm["base"]} → {arm["tip"]}: {", ".join(arm["joints"])}')
        print(f'    left out: {", ".join(arm["left_out"]) or "nothing"}')


def compare(ending, title):
    counted, others = files(ending)
    right = 0
    for name, answer in answers(counted).items():
        said = verdict(name, counted[name], answer)
        right += said == 'right'
        if FULL or said != 'right':
            print(name, said, sep='\n  ')
        if FULL:
            show(answer)
    print(f'{title}: {right} of {len(counted)} right at once; {others} files are not of arms')


def combine():
    """Puts each gripper of the packages on two arms, and looks for its joints in the chains."""
    packages = next(VENV.rglob('robosuite')).parent
    grippers = sorted(packages.glob('robosuite*/**/grippers/*.xml')) + sorted(packages.glob('**/robotiq_2f85/*.xml'))
    # The prefix has no word that tells what it is.
    prefix, made = 'g_', []
    for arm in ('panda', 'baxter'):
        for gripper in grippers:
            file = packages / f'robosuite/models/assets/robots/{arm}/robot.xml'
            if model := mujoco_models.with_gripper(file, 'right_hand', gripper, prefix):
                made.append(MADE / 'grippers' / arm / f'{gripper.stem}.urdf')
                mujoco_models.convert(model, made[-1])
    output = subprocess.run([PROGRAM, *map(str, made)], check=True, capture_output=True, text=True).stdout
    right = 0
    for answer in map(json.loads, output.splitlines()):
        arms = answer.get('arms', [])
        is_right = arms and not any(joint.startswith(prefix) for arm in arms for joint in arm['joints'])
        right += bool(is_right)
        if not is_right:
            print(answer['file'], answer.get('error', 'wrong'), sep='\n  ')
            show(answer)
    print(f'{right} of {len(made)} arms with a gripper have no joint of the gripper in their chain')


if '--grippers' in sys.argv:
    combine()
else:
    compare('urdf', 'URDF')
    compare('xacro', 'xacro')
    compare('xml', 'MJCF')
