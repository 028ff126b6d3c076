//! The shortest time along a line of the tool, with the postures nearest to the first one: the largest squares of speed x = σ̇² at 400
//! places, from a pass backwards and a pass forwards.

use nalgebra::Vector3;
use revprio_robot::RobotModel;
use revprio_robot::kinematics::{Configuration, orientation_error};

const PLACES: usize = 400;

/// Returns the time from a posture (n) along a way of the tool (m), s.
pub fn time(robot: &RobotModel, start: &[f64], way: Vector3<f64>) -> f64 {
    let path = postures(robot, start, way);
    let step = 1.0 / PLACES as f64;
    let joints: Vec<_> = robot.joints().iter().map(|joint| joint.limits).collect();
    let rates = |i: usize, j: usize| {
        let k = i.clamp(1, PLACES - 1);
        let second = (path[k + 1][j] - 2.0 * path[k][j] + path[k - 1][j]) / step / step;
        [(path[k + 1][j] - path[k - 1][j]) / (2.0 * step) + second * (i as f64 - k as f64) * step, second]
    };
    // The range of σ̈ at place i and x.
    let range = |i: usize, x: f64| {
        joints.iter().enumerate().fold([f64::MIN, f64::MAX], |[low, high], (j, limits)| {
            let [first, second] = rates(i, j);
            let [a, b] = [-1.0, 1.0].map(|side| (side * limits.acceleration - second * x) / first);
            if first.abs() < 1e-6 { [low, high] } else { [low.max(a.min(b)), high.min(a.max(b))] }
        })
    };
    let most = |i: usize| {
        joints
            .iter()
            .enumerate()
            .map(|(j, l)| (l.velocity / rates(i, j)[0].abs().max(1e-9)).powi(2))
            .fold(f64::MAX, f64::min)
    };
    let mut squares = vec![0.0; PLACES + 1];
    for i in (0..PLACES).rev() {
        let (mut low, mut high) = (0.0, most(i));
        for _ in 0..60 {
            let x = 0.5 * (low + high);
            let [least, greatest] = range(i, x);
            if least <= greatest && x + 2.0 * step * least <= squares[i + 1] { low = x } else { high = x }
        }
        squares[i] = low;
    }
    let (mut x, mut time) = (0.0_f64, 0.0);
    for i in 0..PLACES {
        let next = (x + 2.0 * step * range(i, x)[1]).min(squares[i + 1]).max(0.0);
        time += 2.0 * step / (x.sqrt() + next.sqrt());
        x = next;
    }
    time
}

/// Returns the postures along the line, by small steps of least squares with a pull to the first posture in the null space.
fn postures(robot: &RobotModel, start: &[f64], way: Vector3<f64>) -> Vec<Vec<f64>> {
    let first = nalgebra::DVector::from_row_slice(start);
    let start = *Configuration::new(robot, start).unwrap().tool_pose();
    let mut q = first.clone();
    let mut path = Vec::new();
    for i in 0..=PLACES {
        for _ in 0..30 {
            let at = Configuration::new(robot, q.as_slice()).unwrap();
            let moved = start.translation.vector + way * (i as f64 / PLACES as f64) - at.tool_pose().translation.vector;
            let turned = -orientation_error(&at.tool_pose().rotation, &start.rotation);
            let error = nalgebra::DVector::from_iterator(6, moved.iter().chain(turned.iter()).copied());
            let jacobian = nalgebra::DMatrix::from_fn(6, q.len(), |r, c| at.jacobian()[(r, c)]);
            let inverse = jacobian.clone().pseudo_inverse(1e-6).unwrap();
            let pull = &first - &q;
            q += &inverse * error + (&pull - &inverse * (&jacobian * &pull)) * 0.5;
        }
        path.push(q.as_slice().to_vec());
    }
    path
}
