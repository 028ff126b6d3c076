"""MuJoCo models: converts them to URDF by the Python client, and compares poses with those of MuJoCo."""
import client
import mujoco
import numpy as np

# Otherwise MuJoCo writes its warnings to a file in the present directory.
mujoco.set_mju_user_warning(lambda _: None)

def convert(model, target):
    """Writes the URDF text of a file or model. MJCF states no speeds, so every joint gets 1 rad/s or 1 m/s."""
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(client.module('mjcf').read_mjcf(model, velocity_limits=1.0))


def with_gripper(arm, body, gripper, prefix):
    """The model of an arm with a gripper on one of its bodies; None if MuJoCo cannot combine the files."""
    try:
        spec, tool = mujoco.MjSpec.from_file(str(arm)), mujoco.MjSpec.from_file(str(gripper))
        spec.attach(tool, frame=spec.body(body).add_frame(), prefix=prefix)
        return spec.compile()
    except ValueError as error:
        print(f'{gripper.name} on {arm.parent.name}: {error}')
        return None


def error(file, arm):
    """The largest difference from MuJoCo in position, m, and entries of the rotation, at the postures of an arm."""
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    base = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, arm['base'])
    worst = 0.0
    for pose in arm['poses']:
        for joint, position in zip(arm['joints'], pose['posture'], strict=True):
            data.joint(joint).qpos[0] = position
        mujoco.mj_kinematics(model, data)
        site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, arm['tip'])
        tip = data.site(site) if site >= 0 else data.body(arm['tip'])
        turn = data.xmat[base].reshape(3, 3).T
        position, rotation = turn @ (tip.xpos - data.xpos[base]), turn @ tip.xmat.reshape(3, 3)
        differences = [position - pose['position'], rotation.ravel() - pose['rotation']]
        worst = max(worst, *(float(np.abs(difference).max()) for difference in differences))
    return worst
