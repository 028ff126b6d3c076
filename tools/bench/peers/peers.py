"""Solves the problems in Python with NumPy on Pinocchio, placo or pink: python peers.py FILE URDF PROGRAM

PROGRAM is placo or pink; placo needs another version of Pinocchio. The output has the format of peers.cpp. Each call
includes kinematics and resolution. placo and pink are used with weights instead of priorities: task x has 1000 times the
weight of the others. The error columns show the effect on the accuracy.
"""
import sys
import time
from pathlib import Path

import numpy as np
import pinocchio

FILE, URDF, PROGRAM = sys.argv[1:]
ROWS = np.loadtxt(FILE, delimiter=',')
Q, XDOT, LIMIT, CLOSED, EXACT = np.split(ROWS, [7, 13, 20, 27], axis=1)
WEIGHT = 1e3
DT = 1e-3
model = pinocchio.buildModelFromUrdf(URDF)
data, frame = model.createData(), model.getFrameId('tool')


def jacobian(q):
    pinocchio.computeJointJacobians(model, data, q)
    return pinocchio.getFrameJacobian(model, data, frame, pinocchio.LOCAL_WORLD_ALIGNED)


def report(name, solve, exact, rounds=5):
    error = first = 0.0
    for i, q in enumerate(Q):
        difference = solve(i) - exact[i]
        pinocchio.updateFramePlacements(model, data)
        error, first = max(error, abs(difference).max()), max(first, abs(jacobian(q)[0] @ difference))
    times = np.zeros((rounds, len(Q)))
    for turn in times:
        for i in range(len(Q)):
            start = time.perf_counter()
            solve(i)
            turn[i] = time.perf_counter() - start
    times = np.median(times, axis=0)  # other load on the machine does not reach the quantiles
    print(f'{name},{np.median(times):.4e},{np.quantile(times, 0.99, method="nearest"):.4e},{error:.1e},{first:.1e}', flush=True)


def with_numpy(i):
    J = jacobian(Q[i])
    q2 = np.linalg.pinv(J[1:]) @ XDOT[i, 1:]
    T = np.linalg.pinv(J)[:, :1]
    return q2 + T @ np.linalg.pinv(J[:1] @ T) @ (XDOT[i, :1] - J[:1] @ q2)


def with_placo():
    import placo
    robot = placo.RobotWrapper(URDF, placo.Flags.ignore_collisions)
    names = [name for name in model.names[1:]]
    solver = placo.KinematicsSolver(robot)
    solver.mask_fbase(True)
    solver.enable_velocity_limits(True)
    solver.enable_joint_limits(False)
    solver.dt = DT
    first, others = (solver.add_position_task('tool', np.zeros(3)) for _ in range(2))
    first.mask.set_axises('x')
    others.mask.set_axises('yz')
    rotation = solver.add_orientation_task('tool', np.eye(3))
    first.configure('x', 'soft', WEIGHT)
    others.configure('yz', 'soft', 1.0)
    rotation.configure('rotation', 'soft', 1.0)
    solver.add_regularization_task(1e-8)

    def place(i):
        for name, q, limit in zip(names, Q[i], LIMIT[i]):
            robot.set_joint(name, q)
            robot.set_velocity_limit(name, limit)
        robot.update_kinematics()

    def target(i):
        place(i)
        T = robot.get_T_world_frame('tool')
        return T[:3, 3] + DT * XDOT[i, :3], pinocchio.exp3(DT * XDOT[i, 3:]) @ T[:3, :3]

    targets = [target(i) for i in range(len(Q))]  # before the timed calls

    def solve(i):
        place(i)
        position, rotation.R_world_frame = targets[i]
        first.target_world = others.target_world = position
        return solver.solve(False)[-7:] / DT

    return solve


def with_pink():
    import pink
    from pink.limits import VelocityLimit
    from pink.tasks import Task

    class Rows(Task):
        """A pink task for some rows of the tool twist in base axes."""

        def __init__(self, rows, cost):
            super().__init__(cost=cost)
            self.rows, self.xdot = rows, None

        def __repr__(self):
            return f'Rows({self.rows})'

        def compute_error(self, configuration):
            return -DT * self.xdot[self.rows]

        def compute_jacobian(self, configuration):
            return pinocchio.getFrameJacobian(
                configuration.model, configuration.data, frame, pinocchio.LOCAL_WORLD_ALIGNED)[self.rows]

    tasks = [Rows(slice(0, 1), WEIGHT ** 0.5), Rows(slice(1, 6), 1.0)]

    configuration = pink.Configuration(model, data, Q[0])
    limits = [[VelocityLimit(model, limit)] for limit in LIMIT]

    def solve(i):
        configuration.update(Q[i])
        for task in tasks:
            task.xdot = XDOT[i]
        return pink.solve_ik(
            configuration, tasks, DT, solver='daqp', damping=1e-8, limits=limits[i], safety_break=False)

    return solve


def attempt(name, make):
    try:
        report(name, make(), EXACT)
    except Exception as error:  # the table shows the error instead of a time
        print(f'{name}: {type(error).__name__}: {error}'.replace(',', ';').replace('\n', ' '), flush=True)


if PROGRAM == 'placo':
    attempt('limits: placo, weighted (Python)', with_placo)
else:
    report('closed form: Pinocchio + NumPy pinv (Python)', with_numpy, CLOSED)
    attempt('limits: pink with DAQP, weighted (Python)', with_pink)
