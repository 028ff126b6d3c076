//! Kinematics of a tree allocates nothing after the first posture.

use allocation_counter::measure;
use nalgebra::Vector3;
use revprio_robot::kinematics::{Configuration, Jacobian, LinkPoint};
use revprio_robot::{RobotModel, UrdfTreeOptions, built_in};

/// Asserts that an update and what is computed for its first and last link allocate nothing.
fn assert_allocates_nothing(robot: &RobotModel) {
    let n = robot.joint_count();
    let (posture, velocity, mut jacobian) = (vec![0.2; n], vec![1.0; n], Jacobian::zeros(n));
    let mut configuration = Configuration::new(robot, &vec![0.0; n]).unwrap();
    let [first, last] = [&robot.links()[0], &robot.links()[robot.links().len() - 1]].map(|link| robot.link(&link.name));
    let point = LinkPoint::new(last.unwrap(), Vector3::new(0.1, 0.2, 0.3));
    let counted = measure(|| {
        configuration.update(robot, &posture).unwrap();
        for point in [point, point.relative_to(first.unwrap()), point.relative_to(robot.tips()[0].link)] {
            configuration.write_point_jacobian(&point, &mut jacobian);
            std::hint::black_box((configuration.point_pose(&point), configuration.point_twist(&point, &velocity)));
        }
        std::hint::black_box(configuration.tip_pose(&robot.tips()[0]));
    });
    assert_eq!(counted.count_total, 0, "{}", robot.name());
}

#[test]
fn an_update_and_all_queries_allocate_nothing() {
    assert_allocates_nothing(&built_in()[0]);
    let body = include_str!("../../../../fixtures/golden/upper_body.urdf");
    assert_allocates_nothing(&RobotModel::from_urdf_tree(body, &UrdfTreeOptions::default()).unwrap());
}
