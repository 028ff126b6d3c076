"""A ROS 2 node for a force-controlled arm: receives joint states and wrenches, publishes joint velocities."""

import json
import sys

import rclpy
from geometry_msgs.msg import WrenchStamped
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

import conversion
from service import NO_COMMAND_ERRORS, Service


class Revprio(Node):
    def __init__(self, controller, address="127.0.0.1:8080"):
        super().__init__("revprio")
        self.service = Service(address, timeout_s=0.05)
        session = self.service.call("POST", "/v1/controllers", controller)
        robot = self.service.call("GET", f"/v1/robots/{controller['robot']}")
        accelerations = [joint["acceleration_limit"] for joint in robot["joints"]]
        self.joints, self.step = session["joints"], f"/v1/controllers/{session['id']}/step"
        self.watchdog = conversion.Watchdog(accelerations, controller["period_s"])
        self.sequence, self.start_s, self.joint_state, self.wrench = 0, self.now_s(), None, None
        self.create_subscription(JointState, "joint_states", self.on_joint_state, qos_profile_sensor_data)
        self.create_subscription(WrenchStamped, "wrench", self.on_wrench, qos_profile_sensor_data)
        self.commands = self.create_publisher(Float64MultiArray, "forward_velocity_controller/commands", 1)
        self.create_timer(controller["period_s"], self.control)

    def now_s(self):
        return 1e-9 * self.get_clock().now().nanoseconds

    def on_joint_state(self, message):
        self.joint_state = message

    def on_wrench(self, message):
        self.wrench = message

    def control(self):
        self.sequence += 1
        try:
            state = conversion.state(self.joint_state, self.wrench, self.joints, sequence=self.sequence,
                                     start_s=self.start_s, now_s=self.now_s(), max_age_s=0.02)
            answer = self.service.call("POST", self.step, state)
            self.watchdog.update(answer, conversion.seconds(self.joint_state.header.stamp))
        except NO_COMMAND_ERRORS as error:
            self.get_logger().error(str(error), throttle_duration_sec=1.0)
        self.commands.publish(Float64MultiArray(data=self.watchdog.command(self.now_s())))


if __name__ == "__main__":
    rclpy.init()
    with open(sys.argv[1]) as file:
        rclpy.spin(Revprio(json.load(file)))
