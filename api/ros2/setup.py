"""Installs the package with `colcon build`, or with pip."""

from glob import glob

from setuptools import setup

setup(
    name="revprio_ros",
    version="0.1.0",
    description="Controls a redundant arm with revprio: joint states and wrench in, joint velocities out.",
    license="MIT",
    python_requires=">=3.11",
    packages=["revprio_ros"],
    install_requires=["setuptools", "revprio"],
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/revprio_ros"]),
        ("share/revprio_ros", ["package.xml"]),
        ("share/revprio_ros/launch", glob("launch/*")),
        ("share/revprio_ros/config", glob("config/*")),
    ],
    entry_points={
        "console_scripts": ["controller = revprio_ros.controller:main", "simulator = revprio_ros.simulator:main"],
    },
)
