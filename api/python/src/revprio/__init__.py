"""Joint velocities for redundant robot arms with prioritised tasks, in this process or by a service.

    import revprio
    q = [0.3, -0.6, 0.2, 1.4, 0.1, 0.9, 0.0]
    task = revprio.ResolveTask(axes="x", velocity=0.05)
    print(revprio.resolve(robot="sawyer_dh", joint_position=q, tasks=[task]).joint_velocity)

`revprio.Controller` computes a control loop. The functions of this package compute in this process. The object that
`revprio.connect(url)` returns has the same functions, which a service computes; the answers are equal to the last bit.

All units are SI; revolute joints use rad and rad/s. A twist is linear velocity (m/s), then angular velocity (rad/s). A
wrench is force (N), then torque (N·m). Both use base axes at the tool point, unless stated otherwise. Arrays in answers
are NumPy arrays. Requests accept anything that NumPy converts to an array.
"""

from revprio.aio import AsyncClient as AsyncClient
from revprio.chunks import chunk as chunk
from revprio.client import Client as Client
from revprio.connection import LOCAL
from revprio.connection import connect as connect
from revprio.connection import serve as serve
from revprio.controller import Controller as Controller
from revprio.drive import Measurement as Measurement
from revprio.drive import drive as drive
from revprio.errors import *  # noqa: F403
from revprio.local import Local as Local
from revprio.mjcf import read_mjcf as read_mjcf
from revprio.models import *  # noqa: F403
from revprio.pace import Drive as Drive
from revprio.pace import SlowLoopWarning as SlowLoopWarning
from revprio.presets import characteristic_length as characteristic_length
from revprio.presets import follow as follow
from revprio.presets import push as push
from revprio.presets import push_with_damping as push_with_damping
from revprio.presets import wipe as wipe
from revprio.remote import Session as Session
from revprio.remote import Stateless as Stateless
from revprio.remote import Stream as Stream
from revprio.simulations import SimulationError as SimulationError
from revprio.watchdog import Watchdog as Watchdog
from revprio.xacro import read_xacro as read_xacro

resolve = LOCAL.resolve
resolve_batch = LOCAL.resolve_batch
kinematics = LOCAL.kinematics
stability = LOCAL.stability
payload = LOCAL.payload
step = LOCAL.step
session = LOCAL.session
stateless = LOCAL.stateless
robots = LOCAL.robots
robot = LOCAL.robot
register_robot = LOCAL.register_robot
delete_robot = LOCAL.delete_robot
