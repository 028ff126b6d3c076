//! Robots described in TOML or JSON by Denavit-Hartenberg parameters.

use nalgebra::IsometryMatrix3;
use serde::Deserialize;

use super::{DenavitHartenberg, Joint, JointKind, JointLimits, ModelError, RobotModel, VelocityEnvelope};

/// Why a robot description is refused.
#[derive(Debug, thiserror::Error)]
pub enum DescriptionError {
    /// The text is not TOML, or its fields are not those of a robot.
    #[error("robot description: {0}")]
    Toml(#[from] toml::de::Error),
    /// The text is not JSON, or its fields are not those of a robot.
    #[error("robot description: {0}")]
    Json(#[from] serde_json::Error),
    /// The text is well-formed, but its joints are not a robot.
    #[error(transparent)]
    Model(#[from] ModelError),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RobotDescription {
    name: String,
    #[serde(default)]
    description: String,
    joints: Vec<JointDescription>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct JointDescription {
    name: String,
    kind: JointKind,
    dh: DenavitHartenberg,
    position_limit: Option<[f64; 2]>,
    velocity_limit: Option<f64>,
    acceleration_limit: Option<f64>,
    jerk_limit: Option<f64>,
    velocity_envelope: Option<EnvelopeDescription>,
    published_range: Option<[f64; 2]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EnvelopeDescription {
    deceleration_limit: f64,
    velocity_offset: f64,
}

impl EnvelopeDescription {
    fn envelope(&self) -> VelocityEnvelope {
        VelocityEnvelope { deceleration: self.deceleration_limit, offset: self.velocity_offset }
    }
}

impl JointDescription {
    fn limits(&self) -> JointLimits {
        let [lower, upper] = self.position_limit.unwrap_or([JointLimits::NONE.lower, JointLimits::NONE.upper]);
        JointLimits {
            lower,
            upper,
            velocity: self.velocity_limit.unwrap_or(JointLimits::NONE.velocity),
            acceleration: self.acceleration_limit.unwrap_or(JointLimits::NONE.acceleration),
            jerk: self.jerk_limit.unwrap_or(JointLimits::NONE.jerk),
            envelope: self.velocity_envelope.as_ref().map_or(VelocityEnvelope::NONE, EnvelopeDescription::envelope),
        }
    }
}

impl RobotDescription {
    fn build(self) -> Result<RobotModel, ModelError> {
        let mut placement = IsometryMatrix3::identity();
        let mut joints = Vec::with_capacity(self.joints.len());
        for joint in self.joints {
            joints.push(Joint {
                kind: joint.kind,
                limits: joint.limits(),
                published_range: joint.published_range,
                denavit_hartenberg: Some(joint.dh),
                name: joint.name,
                placement,
            });
            placement = joint.dh.after_motion();
        }
        RobotModel::new(self.name, self.description, joints, placement)
    }
}

/// Reads a robot from TOML.
pub fn from_toml(text: &str) -> Result<RobotModel, DescriptionError> {
    Ok(toml::from_str::<RobotDescription>(text)?.build()?)
}

/// Reads a robot from JSON, with the same fields as in TOML.
pub fn from_json(text: &str) -> Result<RobotModel, DescriptionError> {
    Ok(serde_json::from_str::<RobotDescription>(text)?.build()?)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;
    use crate::built_in;

    /// Position limits of the manufacturer's description (URDF), joint by joint.
    const URDF_RANGE: [[f64; 2]; 7] = [
        [-3.0503, 3.0503],
        [-3.8095, 2.2736],
        [-3.0426, 3.0426],
        [-3.0439, 3.0439],
        [-2.9761, 2.9761],
        [-2.9761, 2.9761],
        [-4.7124, 4.7124],
    ];

    #[test]
    fn sawyer_limits_are_the_manufacturers_under_the_map_to_table_1() {
        let sign = [1.0, -1.0, 1.0, 1.0, 1.0, -1.0, 1.0];
        let offset = [PI, -FRAC_PI_2, PI, 0.0, PI, 0.0, 0.0];
        let sawyer = &built_in()[0];
        assert_eq!(sawyer.name(), "sawyer_dh");
        for (i, joint) in sawyer.joints().iter().enumerate() {
            let mut mapped = URDF_RANGE[i].map(|q| sign[i] * q + offset[i]);
            mapped.sort_by(f64::total_cmp);
            assert!((joint.limits.lower - mapped[0]).abs() < 1e-12, "{}", joint.name);
            assert!((joint.limits.upper - mapped[1]).abs() < 1e-12, "{}", joint.name);
            assert_eq!(joint.published_range, Some([-PI, PI]), "{}", joint.name);
        }
        let speeds: Vec<f64> = sawyer.joints().iter().map(|joint| joint.limits.velocity).collect();
        assert_eq!(speeds, [1.74, 1.328, 1.957, 1.957, 3.485, 3.485, 4.545]);
        let accelerations: Vec<f64> = sawyer.joints().iter().map(|joint| joint.limits.acceleration).collect();
        assert_eq!(accelerations, [8.0, 8.0, 8.0, 8.0, 10.0, 10.0, 10.0]);
    }

    fn error_text(joints: &str) -> String {
        from_toml(&format!("name = 'r'\n{joints}")).unwrap_err().to_string()
    }

    #[test]
    fn errors_name_the_joint_and_the_line() {
        let joint = |name: &str, extra: &str| {
            format!(
                "[[joints]]\nname = '{name}'\nkind = 'revolute'\ndh = {{ d = 0.0, a = 1.0, alpha = 0.0 }}\n{extra}\n"
            )
        };
        assert!(error_text("joints = []").contains("at least one joint"));
        assert!(error_text(&(joint("a", "") + &joint("a", ""))).contains("two joints are named `a`"));
        assert!(error_text(&joint("a", "position_limit = [1.0, -1.0]")).contains("joint `a`: the position range"));
        assert!(error_text(&joint("a", "velocity_limit = 0.0")).contains("positive"));
        assert!(error_text(&joint("a", "speed = 1.0")).contains("line 6"));
        let not_finite = "[[joints]]\nname = 'a'\nkind = 'revolute'\ndh = { d = nan, a = 0.0, alpha = 0.0 }";
        assert!(error_text(not_finite).contains("joint `a`: lengths and angles must be finite"));
        assert!(error_text(&joint("a", "").replace("a = 1.0", "a = 1e308")).contains("joint `a`: lengths"));
    }

    #[test]
    fn a_velocity_envelope_is_optional_and_leaves_a_range() {
        let joint = |envelope: &str| {
            let dh = "dh = { d = 0.0, a = 1.0, alpha = 0.0 }\nposition_limit = [-1.0, 1.0]";
            from_toml(&format!("name = 'r'\n[[joints]]\nname = 'a'\nkind = 'revolute'\n{dh}\n{envelope}"))
        };
        let stated = joint("velocity_envelope = { deceleration_limit = 6.0, velocity_offset = 0.3 }").unwrap();
        assert_eq!(stated.joints()[0].limits.envelope, VelocityEnvelope { deceleration: 6.0, offset: 0.3 });
        assert_eq!(joint("").unwrap().joints()[0].limits.envelope, VelocityEnvelope::NONE);
        for wrong in ["0.0 0.3", "nan 0.3", "6.0 -0.1", "6.0 inf", "0.1 1.0"] {
            let (deceleration, offset) = wrong.split_once(' ').unwrap();
            let envelope =
                format!("velocity_envelope = {{ deceleration_limit = {deceleration}, velocity_offset = {offset} }}");
            let error = joint(&envelope).unwrap_err().to_string();
            assert!(error.contains("joint `a`") && error.contains("envelope"), "{wrong}: {error}");
        }
    }

    #[test]
    fn a_jerk_limit_is_optional_and_positive() {
        let joint = |jerk: &str| {
            let dh = "dh = { d = 0.0, a = 1.0, alpha = 0.0 }";
            from_toml(&format!("name = 'r'\n[[joints]]\nname = 'a'\nkind = 'revolute'\n{dh}\n{jerk}"))
        };
        assert_eq!(joint("").unwrap().joints()[0].limits.jerk, f64::INFINITY);
        assert_eq!(joint("jerk_limit = 90.0").unwrap().joints()[0].limits.jerk, 90.0);
        assert!(joint("jerk_limit = -1.0").unwrap_err().to_string().contains("jerk limits must be positive"));
    }

    #[test]
    fn json_and_toml_describe_the_same_robot() {
        let toml = "name = 'one'\n[[joints]]\nname = 'a'\nkind = 'prismatic'\ndh = { d = 0.1, a = 0.2, alpha = 0.3 }";
        let json = r#"{"name":"one","joints":[{"name":"a","kind":"prismatic","dh":{"d":0.1,"a":0.2,"alpha":0.3}}]}"#;
        assert_eq!(from_toml(toml).unwrap(), from_json(json).unwrap());
    }
}
