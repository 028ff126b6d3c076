"""Compares the kinematics of whole trees with Pinocchio's: `trees.py PROGRAM [TIMER]`; the script `trees` starts it.

Prints a line per URDF file of PyPI's example-robot-data: joints, outermost links, the largest differences of a pose and
of a Jacobian at 20 postures, and times as multiples of Pinocchio's; or why the file cannot be compared. Fails if a
difference is above 1e-12.
"""
import json
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pinocchio

TOLERANCE = 1e-12
NO_CELLS = [''] * 6


def files():
    """The URDF files of the package by their names."""
    found = Path(sys.prefix).rglob('share/example-robot-data/robots/**/*.urdf')
    return {str(path).split('/robots/')[-1]: path for path in sorted(found)}


def ours(path):
    """The answer for a file."""
    return json.loads(subprocess.run([sys.argv[1], str(path)], check=True, capture_output=True, text=True).stdout)


def complete(path, target):
    """Writes a file with a range and a speed for every joint that has none, which the kinematics do not need."""
    tree = ET.parse(path)
    for joint in tree.getroot().iterfind('joint'):
        if joint.get('type') not in ('revolute', 'prismatic', 'continuous'):
            continue
        limit = joint.find('limit')
        if limit is None:
            limit = ET.SubElement(joint, 'limit')
        if 'lower' not in limit.attrib or 'upper' not in limit.attrib or abs(float(limit.get('upper'))) > 1e9:
            limit.set('lower', '-1')
            limit.set('upper', '1')
        if not 0 < float(limit.get('velocity', 0)) <= 1e9:
            limit.set('velocity', '1')
    tree.write(target)


class Tree:
    """A model of Pinocchio whose mimic joints follow others."""

    def __init__(self, path):
        self.model = pinocchio.buildModelFromUrdf(str(path))
        self.mimics = {}
        for joint in ET.parse(path).getroot().iterfind('joint'):
            mimic = joint.find('mimic')
            if mimic is not None and self.model.existJointName(joint.get('name')):
                numbers = [float(mimic.get(name, default)) for name, default in (('multiplier', 1), ('offset', 0))]
                self.mimics[joint.get('name')] = (mimic.get('joint'), *numbers)

    def joint(self, name):
        return self.model.joints[self.model.getJointId(name)]

    def moving(self):
        """Names of the joints with a coordinate of their own."""
        return [name for name in list(self.model.names)[1:] if name not in self.mimics]

    def configuration(self, positions):
        """Pinocchio's coordinates; a continuous joint has cosine and sine."""
        positions = positions | {
            name: multiplier * positions[source] + offset
            for name, (source, multiplier, offset) in self.mimics.items() if source in positions
        }
        q = pinocchio.neutral(self.model)
        for name, position in positions.items():
            joint = self.joint(name)
            q[joint.idx_q:joint.idx_q + joint.nq] = position if joint.nq == 1 else [np.cos(position), np.sin(position)]
        return q

    def columns(self, jacobian, names):
        """The columns of joints, with those of the joints that follow them."""
        result = jacobian[:, [self.joint(name).idx_v for name in names]]
        for name, (source, multiplier, _) in self.mimics.items():
            if source in names:
                result[:, names.index(source)] += multiplier * jacobian[:, self.joint(name).idx_v]
        return result

    def difference(self, answer):
        """The largest differences of poses (m, entries of rotations) and of Jacobians."""
        data, names = self.model.createData(), answer['joints']
        base, *frames = (self.model.getFrameId(link, pinocchio.BODY) for link in [answer['base'], *answer['links']])
        largest = [0.0, 0.0]
        for each in answer['postures']:
            q = self.configuration(dict(zip(names, each['posture'], strict=True)))
            pinocchio.computeJointJacobians(self.model, data, q)
            pinocchio.updateFramePlacements(self.model, data)
            turn = data.oMf[base].rotation.T
            for frame, link in zip(frames, each['links'], strict=True):
                pose = data.oMf[base].actInv(data.oMf[frame])
                jacobian = pinocchio.getFrameJacobian(self.model, data, frame, pinocchio.LOCAL_WORLD_ALIGNED)
                jacobian = self.columns(np.vstack([turn @ jacobian[:3], turn @ jacobian[3:]]), names)
                differences = [pose.translation - link['position'], pose.rotation.ravel() - link['rotation']]
                largest[0] = max(largest[0], *(float(np.abs(part).max()) for part in differences))
                largest[1] = max(largest[1], float(np.abs(jacobian.ravel() - link['jacobian']).max()))
        return largest

    def time_ns(self, folder, answer, links):
        """Pinocchio's time for the same postures and some links, ns."""
        postures = [dict(zip(answer['joints'], each['posture'], strict=True)) for each in answer['postures']]
        lines = [' '.join(links)]
        lines += [' '.join(repr(float(x)) for x in self.configuration(posture)) for posture in postures]
        command = [sys.argv[2], str(folder / 'model.txt')]
        self.model.saveToText(command[1])
        return float(subprocess.run(command, input='\n'.join(lines), check=True, capture_output=True, text=True).stdout)


def compare(path, folder):
    """The cells of a file after its name, and whether the kinematics are equal."""
    answer, remark = ours(path), ''
    if any(word in answer.get('error', '') for word in ('<limit>', 'velocity limit', 'lower=')):
        reason, completed = answer['error'], folder / path.name
        complete(path, completed)
        answer, path, remark = ours(completed), completed, f', with limits of its joints added ({reason.split(": ")[1]})'
    if 'error' in answer:
        return [*NO_CELLS, f'not read: {answer["error"]}'], None
    tree = Tree(path)
    pose, jacobian = tree.difference(answer)
    missing = sorted(set(tree.moving()) - set(answer['joints']))
    if missing:
        remark += f', without {", ".join(missing)}'
    cells = [str(len(answer['joints'])), str(len(answer['links'])), f'{max(pose, jacobian):.1e}', *['–'] * 3]
    if len(sys.argv) > 2:
        ratio = answer['time_ns'] / tree.time_ns(folder, answer, answer['links'])
        tool = answer['tool_time_ns'] / tree.time_ns(folder, answer, [answer['tool']])
        cells[3:] = [f'{answer["tool_time_ns"]:.0f}', f'{tool:.2f}', f'{ratio:.2f}']
    is_equal = max(pose, jacobian) <= TOLERANCE
    return [*cells, ('equal' if is_equal else '**different**') + remark], is_equal


def main():
    named = files()
    results, ratios = [], []
    print('| file | joints | outermost links | largest difference | one tip, ns | one tip: ratio | all links: ratio | result |')
    print('| --- | ---: | ---: | ---: | ---: | ---: | ---: | --- |')
    with tempfile.TemporaryDirectory() as folder:
        for name, path in named.items():
            cells, is_equal = compare(path, Path(folder))
            print(f'| {name} | {" | ".join(cells)} |', flush=True)
            results.append(is_equal)
            if is_equal and len(sys.argv) > 2:
                ratios.append([float(cell) for cell in cells[4:6]])
    print(f'{results.count(True)} of {len(named)} equal, {results.count(None)} not read, {results.count(False)} different')
    for what, each in zip(('one tip', 'all outermost links'), zip(*ratios), strict=False):
        print(f'{what}: time / that of Pinocchio: median {np.median(each):.2f}, largest {max(each):.2f}')
    sys.exit(1 if False in results else 0)


if __name__ == '__main__':
    main()
