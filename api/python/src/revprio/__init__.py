"""Client of the revprio service: joint velocities for redundant robot arms with prioritised tasks.

    from revprio import Client, ResolveTask
    with Client("http://127.0.0.1:8080") as client:
        q = [0.3, -0.6, 0.2, 1.4, 0.1, 0.9, 0.0]
        print(client.resolve(robot="sawyer_dh", joint_position=q, tasks=[ResolveTask(axes=["x"], velocity=[0.05])]))

All units are SI; revolute joints use rad and rad/s. A twist is linear velocity (m/s), then angular velocity (rad/s). A
wrench is force (N), then torque (N·m). Both use base axes at the tool point, unless stated otherwise. Arrays in answers
are NumPy arrays. Requests accept anything that NumPy converts to an array.
"""

from revprio.aio import AsyncClient as AsyncClient
from revprio.client import Client as Client
from revprio.controller import Controller as Controller
from revprio.controller import Session as Session
from revprio.controller import Stateless as Stateless
from revprio.controller import Stream as Stream
from revprio.drive import Drive as Drive
from revprio.drive import Measurement as Measurement
from revprio.drive import drive as drive
from revprio.errors import *  # noqa: F403
from revprio.models import *  # noqa: F403
from revprio.watchdog import Watchdog as Watchdog
