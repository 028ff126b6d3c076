"""ROS 2 nodes that control an arm with revprio."""
