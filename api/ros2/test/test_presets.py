"""Tests of the controllers in one line, without ROS."""

import unittest

import revprio
from revprio_ros.presets import PresetError, body, is_preset


def plain(tasks):
    return [task.model_dump(exclude_none=True) for task in tasks]


class Lines(unittest.TestCase):
    def test_a_push_has_the_tasks_of_the_client(self):
        made = body("push panda z -15 approach_speed=0.01", 0.004)
        config = revprio.ControllerConfig.model_validate(made)
        expected = revprio.presets.push("z", -15, period_s=0.004, approach_speed=0.01)
        self.assertEqual((config.robot, config.period_s, plain(config.tasks)), ("panda", 0.004, plain(expected)))
        self.assertNotIn("drive", made)

    def test_a_wipe_moves_along_a_second_axis_of_an_arm_with_this_drive(self):
        made = body("wipe sawyer z -15 y stroke_m=-0.2 lag_s=0.01 delay_periods=1")
        config = revprio.ControllerConfig.model_validate(made)
        expected = revprio.presets.wipe("z", -15, "y", stroke_m=-0.2, period_s=0.01, lag_s=0.01, delay_periods=1)
        self.assertEqual((config.period_s, plain(config.tasks)), (0.01, plain(expected)))
        self.assertEqual(made["drive"], {"lag_s": 0.01, "delay_periods": 1})

    def test_files_and_json_are_no_lines(self):
        self.assertTrue(all(map(is_preset, ("push", "push panda z -15", "wipe panda z -15 y"))))
        self.assertFalse(any(map(is_preset, ("push.json", "/tmp/push panda.json", "{}", "pushpanda z 1", ""))))

    def test_a_wrong_word_is_named_with_what_to_write(self):
        for line, text in (
            ("push", "lacks a word; write push ROBOT AXIS NEWTONS"),
            ("push panda z", "lacks a word"),
            ("push panda z approach_speed=0.1", "lacks a word"),
            ("wipe panda z -15", "lacks a word; write wipe ROBOT AXIS NEWTONS ALONG"),
            ("push panda z down", "NEWTONS: 'down' is not a number"),
            ("push panda z 1_000", "NEWTONS: '1_000' is not a number"),
            ("push panda z -15 lag_s=0.01 lag_s=0.2", "gives lag_s twice"),
            ("push panda z -15 period_s=0.004", "parameter `period_s` of the node"),
            ("push panda z -15 y", "'y' is no option of `push`"),
            ("push panda z -15 stroke_m=0.1", "'stroke_m=0.1' is no option of `push`"),
            ("push panda z -15 lag_s=fast", "lag_s: 'fast' is not a number"),
            ("push panda z -15 delay_periods=1.5", "delay_periods: '1.5' is not a whole number"),
            ("push panda z -15 delay_periods=nan", "delay_periods: 'nan' is not a number"),
            ("push panda z 0", "/newtons: give a force"),
            ("push panda z nan", "NEWTONS: 'nan' is not a number"),
            ("push panda z -15 approach_speed=-1", "/approach_speed: give a number above 0"),
            ("push panda up -15", "'up' is unknown"),
            ("wipe panda z -15 z", "/along"),
        ):
            with self.subTest(line), self.assertRaises(PresetError) as caught:
                body(line)
            self.assertIn(text, str(caught.exception))


if __name__ == "__main__":
    unittest.main()
