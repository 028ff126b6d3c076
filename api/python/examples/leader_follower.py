"""A leader arm leads a follower by chunks of joint positions, within its limits. A file can be the leader.

python3 leader_follower.py                         # a simulated leader
python3 leader_follower.py episode.parquet         # the first episode in a file of a LeRobot dataset
python3 leader_follower.py episode.parquet so101   # the same for another arm than `panda`

The file has the columns timestamp and action (degrees). What an action has after the joints of the arm is left out.
"""

import sys
from collections.abc import Iterator

import numpy as np

import revprio

ROBOT = sys.argv[2] if len(sys.argv) > 2 else "panda"
PERIOD_S, ACTIONS = 0.01, 10
SETTLING_S = 0.5


def simulated() -> Iterator[tuple[float, np.ndarray]]:
    """Yields time (s) and joint positions (rad) of a hand-held leader at 30 Hz, with a jump at 2 s."""
    rest = np.array([0, -0.785, 0, -2.356, 0, 1.571, 0.785])
    for t in np.arange(0, 4, 1 / 30):
        yield t, rest + 0.3 * np.sin(t * np.arange(1, 8) / 3) + (0.2 if t > 2 else 0.0)


def recorded(path: str) -> Iterator[tuple[float, np.ndarray]]:
    """Yields time (s) and joint positions (rad) of an episode in a file."""
    import pandas  # noqa: PLC0415

    episode = pandas.read_parquet(path)
    if "episode_index" in episode:
        episode = episode[episode["episode_index"] == episode["episode_index"].iloc[0]]
    for t, action in zip(episode["timestamp"], episode["action"], strict=True):
        yield float(t), np.deg2rad(action[:JOINTS])


JOINTS = len(revprio.Local().robot(ROBOT).joints)
frames = list(recorded(sys.argv[1]) if sys.argv[1:] else simulated())
law = revprio.PostureLaw(gain=8.0, target_position=frames[0][1])
task = revprio.ControllerTask(name="follow", law=law)
follower = revprio.Controller(
    robot=ROBOT, tasks=[task], period_s=PERIOD_S, drive=revprio.JointDrive(lag_s=0, delay_periods=0)
)
q, fastest, sent = frames[0][1], 0.0, 0
for period in range(int((frames[-1][0] + SETTLING_S) / PERIOD_S)):
    now, targets = period * PERIOD_S, None
    if sent < len(frames) and now >= frames[sent][0]:
        times, positions = zip(*frames[sent : sent + ACTIONS], strict=True)
        targets = {"follow": revprio.chunk(times, joint_position=np.array(positions))}
        # The last chunk has all that is left.
        sent = sent + ACTIONS // 2 if sent + ACTIONS < len(frames) else len(frames)
    answer = follower.step(q, time_s=now, targets=targets)  # on an arm: read q, send answer.joint_velocity
    q = q + PERIOD_S * answer.joint_velocity
    fastest = max(fastest, float(np.abs(answer.joint_velocity).max()))
print(
    f"{sent} actions sent, fastest joint {fastest:.2f} rad/s, {np.abs(q - frames[-1][1]).max():.3f} rad off at the end"
)
