//! Linear inequalities in addition to the joint limits.

use revprio_api::wire;
use revprio_core::constraint::{APPROACH_RATE, Constraint, Inequality, MAX_CONSTRAINT_ROWS, PlanePoint, VirtualPlane};
use revprio_robot::RobotModel;

use super::numbers::{check_numbers, joint_list, number};
use crate::service::error::ApiError;

/// Maximum number of inequalities of a request.
pub const MAX_INEQUALITIES: usize = MAX_CONSTRAINT_ROWS;

/// Reads inequalities.
pub struct InequalityReader<'a> {
    /// The robot, which planes need.
    pub robot: Option<&'a RobotModel>,
    /// Number of joints.
    pub joints: usize,
    /// Control period T, s, if known.
    pub period_s: Option<f64>,
}

impl InequalityReader<'_> {
    /// Reads the list at the JSON pointer `/inequalities`.
    pub fn read(&self, list: &[wire::Inequality]) -> Result<Vec<Constraint>, ApiError> {
        if list.len() > MAX_INEQUALITIES {
            let detail = format!("give at most {MAX_INEQUALITIES} inequalities");
            return Err(ApiError::invalid("/inequalities", detail));
        }
        let constraints = list
            .iter()
            .enumerate()
            .map(|(i, inequality)| {
                self.constraint(i, inequality).map_err(|error| error.inside(&format!("/inequalities/{i}")))
            })
            .collect::<Result<Vec<_>, _>>()?;
        for (i, constraint) in constraints.iter().enumerate() {
            if constraints[..i].iter().any(|earlier| earlier.name() == constraint.name()) {
                let detail = format!("two inequalities are named `{}`; give each its own name", constraint.name());
                return Err(ApiError::invalid(format!("/inequalities/{i}/name"), detail));
            }
        }
        Ok(constraints)
    }

    fn constraint(&self, index: usize, inequality: &wire::Inequality) -> Result<Constraint, ApiError> {
        let name_or_default =
            |name: &Option<String>| name.clone().unwrap_or_else(|| format!("inequality {}", index + 1));
        match inequality {
            wire::Inequality::Joints { name, coefficients, upper } => {
                let coefficients = joint_list(coefficients, self.joints, "/coefficients")?;
                let upper = number(*upper, "/upper")?;
                Inequality::new(name_or_default(name), coefficients, upper)
                    .map(Constraint::Fixed)
                    .map_err(|error| ApiError::invalid("/coefficients", error))
            }
            wire::Inequality::Plane { name, normal, offset_m, point, rate_per_s } => {
                check_numbers(normal, "/normal")?;
                let offset = number(*offset_m, "/offset_m")?;
                let point = self.point(point, "/point")?;
                let rate = self.rate(*rate_per_s, "/rate_per_s")?;
                VirtualPlane::new(name_or_default(name), *normal, offset, point, rate)
                    .map(Constraint::Plane)
                    .map_err(|error| ApiError::invalid("/normal", error))
            }
        }
    }

    fn point(&self, point: &str, pointer: &str) -> Result<PlanePoint, ApiError> {
        let Some(robot) = self.robot else {
            return Err(ApiError::invalid(pointer, "a plane needs `robot` and `joint_position`"));
        };
        if point == "tool" {
            return Ok(PlanePoint::Tool);
        }
        let joint = robot.joints().iter().position(|joint| joint.name == point);
        let unknown = || {
            let names: Vec<&str> = robot.joints().iter().map(|joint| joint.name.as_str()).collect();
            format!("`{}` has no joint `{point}`; give `tool` or one of {}", robot.name(), names.join(", "))
        };
        joint.map(PlanePoint::Joint).ok_or_else(|| ApiError::invalid(pointer, unknown()))
    }

    fn rate(&self, rate: Option<f64>, pointer: &str) -> Result<f64, ApiError> {
        let max = self.period_s.map_or(f64::INFINITY, |period| 1.0 / period);
        match rate {
            None => Ok(APPROACH_RATE.min(max)),
            Some(rate) if rate > 0.0 && rate <= max => number(rate, pointer),
            Some(rate) => Err(ApiError::invalid(
                pointer,
                format!("{rate} is out of range; give a positive rate of at most 1 / `period_s`"),
            )),
        }
    }
}
