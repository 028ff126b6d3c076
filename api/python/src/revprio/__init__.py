"""Client of the revprio service: joint velocities for redundant arms that have several tasks in an order of priority.

    from revprio import Client, ResolveTask
    with Client("http://127.0.0.1:8080") as client:
        q = [0.3, -0.6, 0.2, 1.4, 0.1, 0.9, 0.0]
        print(client.resolve(robot="sawyer_dh", joint_position=q, tasks=[ResolveTask(axes=["x"], velocity=[0.05])]))

Units are SI, rad and rad/s for revolute joints. Twists and wrenches are linear (m/s, N) then angular (rad/s, N·m), in
base axes at the tool point unless said otherwise. Arrays of answers are NumPy arrays; requests take whatever NumPy
makes an array of.
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
