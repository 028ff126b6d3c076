"""The law `contact` on torque-controlled arms in MuJoCo; docs/contact-mujoco.md has the results."""
