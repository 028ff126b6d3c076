//! Forward kinematics and Jacobian of Sawyer.

use revprio_robot::built_in;
use revprio_robot::kinematics::Configuration;

use super::plain::Chain;
use super::postures::postures;
use crate::error::BenchError;
use crate::row::Row;
use crate::timing::{Budget, Subject, side_by_side};

pub fn rows(budget: Budget) -> Result<Vec<Row>, BenchError> {
    let robot = &built_in()[0];
    let chain = Chain::of(robot);
    let postures = postures(256);
    let mut posture = Configuration::new(robot, &postures[0]).map_err(BenchError::defect)?;
    let (mut ours, mut plain) = (postures.iter().cycle(), postures.iter().cycle());
    let times = side_by_side(
        budget,
        vec![
            Subject::new("kinematics: pose and Jacobian, Sawyer", || ours.next().map(|q| posture.update(robot, q))),
            Subject::new("4 × 4 matrices, nalgebra", || plain.next().map(|q| chain.jacobian(q))),
        ],
    )?;
    Ok(Row::against_each(&times))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_peer_computes_the_same_jacobian() {
        let robot = &built_in()[0];
        for q in postures(20) {
            let ours = Configuration::new(robot, &q).unwrap();
            let ours = nalgebra::DMatrix::from_fn(6, 7, |i, j| ours.jacobian()[(i, j)]);
            assert!((ours - Chain::of(robot).jacobian(&q)).amax() < 1e-13);
        }
    }
}
