//! Linear inequalities in addition to the joint limits.

use revprio_api::wire;
use revprio_core::constraint::{APPROACH_RATE, Constraint, Inequality, MAX_CONSTRAINT_ROWS, PlanePoint, VirtualPlane};
use revprio_lab::number::Exact;
use revprio_robot::RobotModel;

use super::checks::{Missing, Refused, Result, check, each};
use super::numbers::{check_numbers, joint_index, joint_list, joint_names, number};
use super::pose::{body_frame, frame_names};
use crate::error::ApiError;

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
    pub fn read(&self, list: &[wire::Inequality]) -> Result<Vec<Constraint>> {
        let detail = format_args!("give at most {MAX_INEQUALITIES} inequalities");
        check(list.len() <= MAX_INEQUALITIES, "/inequalities", detail)?;
        let constraints: Vec<Constraint> = each("/inequalities", list, |i, inequality| self.constraint(i, inequality))?;
        for (i, constraint) in constraints.iter().enumerate() {
            if constraints[..i].iter().any(|earlier| earlier.name() == constraint.name()) {
                let detail = format!("two inequalities are named `{}`; give each its own name", constraint.name());
                return Err(ApiError::invalid(format!("/inequalities/{i}/name"), detail));
            }
        }
        Ok(constraints)
    }

    fn constraint(&self, index: usize, inequality: &wire::Inequality) -> Result<Constraint> {
        let named = |name: &Option<String>| name.clone().unwrap_or_else(|| format!("inequality {}", index + 1));
        match inequality {
            wire::Inequality::Joints { name, coefficients, upper } => {
                let coefficients: Vec<f64> = joint_list(coefficients, self.joints, "/coefficients")?;
                let upper = number(*upper, "/upper")?;
                Inequality::new(named(name), coefficients, upper).map(Constraint::Fixed).at("/coefficients")
            }
            wire::Inequality::Plane { name, normal, offset_m, point, rate_per_s } => {
                check_numbers(normal, "/normal")?;
                let offset = number(*offset_m, "/offset_m")?;
                let point = self.point(point, "/point")?;
                let rate = self.rate(*rate_per_s, "/rate_per_s")?;
                VirtualPlane::new(named(name), *normal, offset, point, rate).map(Constraint::Plane).at("/normal")
            }
        }
    }

    fn point(&self, point: &str, pointer: &str) -> Result<PlanePoint> {
        let robot = self.robot.or_invalid(pointer, "a plane needs `robot` and `joint_position`")?;
        if point == "tool" {
            return Ok(PlanePoint::Tool);
        }
        let link = || body_frame(robot, point).map(|frame| PlanePoint::Link(frame.origin()));
        joint_index(robot, point).map(PlanePoint::Joint).or_else(link).ok_or_else(|| {
            let candidates = frame_names(robot);
            let (robot, names) = (robot.name(), joint_names(robot).join(", "));
            let detail =
                format!("`{robot}` has no joint, tip or link `{point}`; give `tool`, a tip, a link or one of {names}");
            ApiError::invalid(pointer, detail).with_candidates(&candidates)
        })
    }

    fn rate(&self, rate: Option<f64>, pointer: &str) -> Result<f64> {
        let max = self.period_s.map_or(f64::INFINITY, |period| 1.0 / period);
        let Some(rate) = rate else { return Ok(APPROACH_RATE.min(max)) };
        let detail = format_args!("{} is out of range; give a positive rate of at most 1 / `period_s`", Exact(rate));
        check(rate > 0.0 && rate <= max, pointer, detail)?;
        number(rate, pointer)
    }
}
