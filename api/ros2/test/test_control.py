"""Tests of the control loop and of the check of the sign, without ROS and with a clock that the tests set."""

import math
import unittest
from concurrent.futures import Future
from types import SimpleNamespace

import numpy as np
import revprio
from revprio_ros.control import Control, Phase
from revprio_ros.conversion import NotUsable
from revprio_ros.sign_check import SignCheck

PERIOD_S = 0.01
DECELERATION = [2.0, 4.0]
MOVING = [0.2, -0.2]


def problem(status):
    return revprio.ProblemError(
        revprio.Problem(type="/problems/implausible", title="", status=status, detail="a reason")
    )


class FakeConnection:
    """Answers at once, as the test says."""

    def __init__(self):
        self.failure, self.is_hanging, self.opened, self.states = None, False, 0, []

    def open(self):
        self.opened += 1
        joint = SimpleNamespace(acceleration_limit=None)
        return self.reply((["a", "b"], [], SimpleNamespace(joints=[joint, joint])))

    def step(self, arguments):
        self.states.append(arguments)
        return self.reply(
            SimpleNamespace(
                joint_velocity=np.array(MOVING),
                valid_for_ms=50,
                stop_time_s=None,
                warnings=[],
                braking_deceleration=np.array(DECELERATION),
            )
        )

    def reply(self, value):
        call = Future()
        if self.failure is not None:
            call.set_exception(self.failure)
        elif not self.is_hanging:
            call.set_result(value)
        return call


class Loops(unittest.TestCase):
    def setUp(self):
        self.now_s, self.stale, self.commands = 100.0, None, []
        self.connection = FakeConnection()
        self.control = Control(self.connection, PERIOD_S)

    def check_fresh(self):
        if self.stale:
            raise NotUsable(self.stale)

    def read(self, joints):
        self.check_fresh()
        return {"joint_position": dict.fromkeys(joints, 0.0)}, self.now_s

    def tick(self, count=1):
        for _ in range(count):
            self.control.update(lambda: self.now_s, self.check_fresh, self.read)
            self.commands.append(self.control.command(self.now_s))
            self.now_s += PERIOD_S

    def start(self):
        self.tick(3)
        self.assertEqual(self.commands[-1], MOVING)
        self.commands.clear()

    def ramp(self):
        """Returns the ramp from MOVING, one command per period."""
        times = [(i + 1) * PERIOD_S for i in range(20)]
        decelerate = lambda v, a, t: math.copysign(max(abs(v) - a * t, 0.0), v)
        return [[decelerate(v, a, t) for v, a in zip(MOVING, DECELERATION)] for t in times]

    def test_it_waits_at_rest_for_fresh_inputs_and_for_a_service(self):
        self.stale = "no message"
        self.tick(5)
        self.assertEqual((self.connection.opened, self.control.problem), (0, "no message"))
        self.stale, self.connection.failure = None, revprio.NoAnswerError("url", "refused")
        self.tick(120)
        self.assertEqual(self.connection.opened, 3, "two attempts per second")
        self.connection.failure = None
        self.tick(60)
        self.assertEqual((self.commands[-1], self.control.problem), (MOVING, ""))

    def check_ramp_after_silence(self):
        # The last state was measured one period ago; its answer is valid for 50 ms. A command is kept for a period.
        self.tick(24)
        self.assertEqual(self.commands[:4], [MOVING] * 4)
        np.testing.assert_allclose(self.commands[4:], self.ramp(), atol=1e-9)
        self.assertEqual(self.control.phase, Phase.WAITING)

    def test_without_answers_the_arm_brakes_and_goes_on_with_a_new_session(self):
        self.start()
        self.connection.failure, settled = revprio.NoAnswerError("url", "refused"), self.control.settled
        self.check_ramp_after_silence()
        self.assertIn("no answer", self.control.problem)
        self.assertEqual(self.control.settled, settled)
        self.connection.failure = None
        self.tick(60)
        self.assertEqual((self.commands[-1], self.connection.opened >= 2), (MOVING, True))

    def test_a_call_that_hangs_does_not_stop_the_commands(self):
        self.start()
        self.connection.is_hanging = True
        self.check_ramp_after_silence()

    def test_stale_inputs_are_not_sent(self):
        self.start()
        sent = len(self.connection.states)
        self.stale = "`wrench` is stale"
        self.check_ramp_after_silence()
        self.assertEqual((len(self.connection.states), self.control.problem), (sent, "`wrench` is stale"))
        self.assertEqual(self.control.state(self.now_s), Phase.WAITING)

    def test_an_answer_before_the_arm_is_at_rest_continues_the_session(self):
        self.start()
        self.stale = "late"
        self.tick(6)
        self.assertEqual(self.control.state(self.now_s), Phase.BRAKING)
        self.stale = None
        self.commands.clear()
        self.tick(3)
        expected = [self.ramp()[0], MOVING, MOVING]
        np.testing.assert_allclose(self.commands, expected, atol=1e-9)
        self.assertEqual(self.connection.opened, 1)

    def test_a_loop_that_was_stopped_goes_on_with_a_new_session(self):
        self.start()
        self.now_s += 10.0
        self.tick()
        self.assertEqual(self.commands[-1], [0.0, 0.0])
        self.tick(3)
        self.assertEqual((self.commands[-1], self.connection.opened), (MOVING, 2))

    def test_a_refused_state_brakes_at_once(self):
        self.start()
        settled = self.control.settled
        self.connection.failure = problem(422)
        self.tick(2)
        # What came with the refused state is not sent again.
        self.assertEqual(self.control.settled, settled + 1)
        np.testing.assert_allclose(self.commands, self.ramp()[:2], atol=1e-9)
        self.assertIn("a reason", self.control.problem)
        self.connection.failure = None
        self.tick(60)
        self.assertEqual((self.commands[-1], self.connection.opened), (MOVING, 2))

    def test_a_session_that_has_ended_is_replaced(self):
        self.start()
        self.connection.failure = problem(404)
        self.tick(30)
        self.assertEqual(self.control.phase, Phase.WAITING)
        self.connection.failure = None
        self.tick(60)
        self.assertEqual(self.commands[-1], MOVING)
        self.assertEqual(self.connection.states[-1]["time_s"] < 1.0, True, "the time of a session begins with it")

    def test_a_state_that_cannot_be_used_is_reported_as_waiting(self):
        self.start()
        read, self.read = self.read, lambda _: (_ for _ in ()).throw(NotUsable("NaN"))
        self.tick(100)
        self.assertEqual((self.control.state(self.now_s), self.control.problem), (Phase.WAITING, "NaN"))
        self.assertEqual(self.commands[-1], [0.0, 0.0])
        self.read = read
        self.commands.clear()
        self.tick(10)
        self.assertEqual(self.control.state(self.now_s), Phase.RUNNING)
        # The first answer of a new session counts at once.
        self.assertEqual(self.commands, [MOVING] * 10)

    def test_a_refused_controller_is_raised(self):
        self.connection.failure = problem(422)
        with self.assertRaises(revprio.ProblemError):
            self.tick(2)

    def test_a_halt_brakes_and_keeps_its_reason(self):
        self.start()
        self.control.halt("wrong sign", self.now_s)
        self.tick(30)
        np.testing.assert_allclose(self.commands[:20], self.ramp(), atol=1e-9)
        self.control.halt("the node is being stopped", self.now_s)
        self.now_s -= 1.0
        self.tick(2)
        self.assertEqual((self.control.phase, self.control.problem), (Phase.HALTED, "wrong sign"))
        self.assertEqual(self.commands[-1], [0.0, 0.0])

    def test_a_clock_that_goes_back_does_not_prolong_a_command(self):
        self.start()
        self.now_s -= 50.0
        self.tick(30)
        np.testing.assert_allclose(self.commands[:10], self.ramp()[:10], atol=1e-9)
        self.assertEqual(self.commands[-1], MOVING, "with a new session")
        self.stale = "late"
        self.tick(8)
        self.assertEqual(self.control.state(self.now_s), Phase.BRAKING)
        self.now_s -= 50.0
        self.tick(3)
        self.assertEqual(self.commands[-3:], [[0.0, 0.0]] * 3)


class SignChecks(unittest.TestCase):
    STIFFNESS = 5000.0

    def finding(self, sign, depths, periods=8):
        """Returns the first finding while the tool is at these depths in an elastic wall at +x."""
        check = SignCheck(25.0, periods)
        found = (check.add([depth, 0.0, 0.0], [sign * self.STIFFNESS * max(depth, 0.0), 0.0, 0.0]) for depth in depths)
        return next(filter(None, found), None)

    def test_pressing_with_the_wrong_sign_is_found(self):
        self.assertIn("wrong sign", self.finding(-1, np.linspace(-0.01, 0.02, 60)))

    def test_it_is_found_soon_also_if_measurements_are_repeated(self):
        depths = np.repeat(np.linspace(-0.01, 0.0075, 36), 2)
        self.assertIn("wrong sign", self.finding(-1, depths))

    def test_pressing_and_retreating_with_the_right_sign_is_not(self):
        self.assertIsNone(self.finding(+1, 0.01 * np.sin(np.linspace(0, 20, 500))))

    def test_a_force_below_the_threshold_is_not_checked(self):
        self.assertIsNone(self.finding(-1, np.linspace(-0.01, 0.0049, 60)))

    def test_noise_at_rest_is_not_a_motion(self):
        self.assertIsNone(self.finding(-1, 0.008 + np.random.default_rng(1).normal(scale=1e-6, size=500)))


if __name__ == "__main__":
    unittest.main()
