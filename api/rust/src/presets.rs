//! Tasks for common jobs.
//!
//! ```
//! use revprio_api::presets::{PressOptions, push};
//! use revprio_api::wire::Axis;
//!
//! let tasks = push(Axis::Z, -15.0, &PressOptions::default())?; // presses downwards with 15 N and holds the other axes
//! assert_eq!(tasks.len(), 2);
//! # Ok::<(), revprio_api::presets::PresetError>(())
//! ```

use std::f64::consts::FRAC_PI_2;

use crate::wire::{Axis, ControllerTask, Frame, Law, PerAxis, Profile, SurfaceFollowing, TargetPose};

/// Largest gain of a pose law, 1/s. The joints of all built-in arms can follow it.
const POSE_GAIN: f64 = 2.0;

/// Largest tilt of a surface that a law accepts, rad.
const MOST_TILT_RAD: f64 = 1.4;

/// Latest start of a motion, s.
const LATEST_S: f64 = 1e6;

/// What [`push`] and [`wipe`] may be told beyond the force.
#[derive(Debug, Clone, PartialEq)]
pub struct PressOptions {
    /// Axes that a further task holds; `None`: all others. An empty list: no such task.
    pub hold: Option<Vec<Axis>>,
    /// T, period of the controller, s.
    pub period_s: f64,
    /// L, lag of the arm's velocity loop, s.
    pub lag_s: f64,
    /// D, delay of a command, periods.
    pub delay_periods: u32,
    /// Speed of the approach, m/s; `None`: the largest that keeps 1.2 times the force.
    pub approach_speed: Option<f64>,
    /// Stiffness of the stiffest contact, N/m; `None`: 1e6.
    pub stiffest: Option<f64>,
    /// Force at which the tool leaves, N.
    pub max_force: Option<f64>,
}

impl Default for PressOptions {
    /// The drive that controllers expect by default, at 1 kHz.
    fn default() -> Self {
        let (period_s, lag_s, delay_periods) = (1e-3, 0.03, 2);
        Self { hold: None, period_s, lag_s, delay_periods, approach_speed: None, stiffest: None, max_force: None }
    }
}

/// What [`wipe`] may be told beyond the force and the axes.
#[derive(Debug, Clone, PartialEq)]
pub struct WipeOptions {
    /// As for [`push`].
    pub press: PressOptions,
    /// Way from the start along the axis and back, m; negative: the other direction.
    pub stroke_m: f64,
    /// Largest speed, m/s.
    pub speed: f64,
    /// Time of the states at which the motion begins, s. On the clock of Unix it counts from the first state.
    pub start_time_s: f64,
    /// Axes of pressing, motion and hold; a pose for a tilted surface.
    pub frame: Frame,
    /// Largest tilt of a surface whose direction is not known, rad. These axes then follow its normal; `None`: they stay.
    pub max_tilt_rad: Option<f64>,
}

impl Default for WipeOptions {
    /// 10 cm and back at up to 5 cm/s along an axis of the base.
    fn default() -> Self {
        Self {
            press: PressOptions::default(),
            stroke_m: 0.1,
            speed: 0.05,
            start_time_s: 0.0,
            frame: Frame::Base,
            max_tilt_rad: None,
        }
    }
}

/// Why a preset gives no tasks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum PresetError {
    /// The force has no direction.
    #[error("the force must be finite and not 0; its sign is the direction in which the tool presses")]
    Force,
    /// The motion has no way.
    #[error("the stroke must be finite and not 0; its sign is the direction in which the motion begins")]
    Stroke,
    /// The motion has no beginning.
    #[error(
        "the start time must be up to {LATEST_S} s, on the clock of the states; on that of Unix it counts from the first state"
    )]
    StartTime,
    /// A number is not positive.
    #[error("{0} must be finite and above 0")]
    NotPositive(&'static str),
    /// The largest tilt is none.
    #[error("the largest tilt must be above 0 and at most {MOST_TILT_RAD} rad")]
    Tilt,
    /// The motion is none along the surface.
    #[error("the motion must be along x, y or z, and along another axis than the one along which the tool presses")]
    Along,
    /// An axis to hold has another task.
    #[error("the axis `{0}` presses or moves already; leave it out of the axes to hold")]
    Held(Axis),
    /// An axis to hold is given more than once.
    #[error("the axis `{0}` is there twice among the axes to hold; give it once")]
    HeldTwice(Axis),
}

/// Returns the tasks that press with a force (N, N·m for an axis of rotation) along one axis of the base and hold the others. The law
/// `contact` needs no stiffness.
pub fn push(axis: Axis, newtons: f64, options: &PressOptions) -> Result<Vec<ControllerTask>, PresetError> {
    let mut tasks = vec![task("push", vec![axis], Frame::Base, contact(newtons, options)?)];
    tasks.extend(hold(&[axis], Frame::Base, options)?);
    Ok(tasks)
}

/// Returns the tasks that press along one axis and move back and forth along another one. The motion begins at
/// [`WipeOptions::start_time_s`], also while the tool still approaches the surface. State that time if the tasks replace others while the
/// arm moves, or if the first state has another time than 0: the arm would else catch up with the motion, faster than
/// [`WipeOptions::speed`].
pub fn wipe(axis: Axis, newtons: f64, along: Axis, options: &WipeOptions) -> Result<Vec<ControllerTask>, PresetError> {
    let WipeOptions { press, stroke_m, speed, start_time_s, frame, max_tilt_rad } = options;
    if !matches!(along, Axis::X | Axis::Y | Axis::Z) || along == axis {
        return Err(PresetError::Along);
    }
    if !stroke_m.is_finite() || *stroke_m == 0.0 {
        return Err(PresetError::Stroke);
    }
    if start_time_s.is_nan() || start_time_s.abs() > LATEST_S {
        return Err(PresetError::StartTime);
    }
    let half = 0.5 * stroke_m;
    let rate = positive("the speed", *speed)? / half.abs();
    // From the start and back: half − half cos ω (t − t_0).
    let way = Profile::Sine {
        offset: PerAxis::All(half),
        amplitude: PerAxis::All(half),
        angular_frequency_rad_s: rate,
        phase_rad: -FRAC_PI_2 - rate * start_time_s,
        start_time_s: (*start_time_s != 0.0).then_some(*start_time_s),
    };
    let sweep = pose(Some(way), press);
    let tilt = max_tilt_rad.map(largest_tilt).transpose()?;
    let mut pressing = contact(newtons, press)?;
    if let Law::Contact { surface, .. } = &mut pressing {
        *surface = tilt.map(|tilt| SurfaceFollowing { max_tilt_rad: Some(tilt) });
    }
    let mut tasks = vec![task("push", vec![axis], *frame, pressing), task("wipe", vec![along], *frame, sweep)];
    tasks.extend(hold(&[axis, along], *frame, press)?);
    Ok(tasks)
}

fn contact(newtons: f64, options: &PressOptions) -> Result<Law, PresetError> {
    if !newtons.is_finite() || newtons == 0.0 {
        return Err(PresetError::Force);
    }
    let given = |name, value: Option<f64>| value.map(|value| positive(name, value).map(PerAxis::All)).transpose();
    Ok(Law::Contact {
        target_force: Profile::Constant { value: PerAxis::All(newtons) },
        approach_speed: given("the approach speed", options.approach_speed)?,
        stiffest: given("the stiffness of the stiffest contact", options.stiffest)?,
        noise: None,
        bias: None,
        sensor_lag_s: None,
        max_force: given("the largest force", options.max_force)?,
        retreat_speed: None,
        max_acceleration: None,
        surface: None,
    })
}

fn positive(name: &'static str, value: f64) -> Result<f64, PresetError> {
    if value.is_finite() && value > 0.0 { Ok(value) } else { Err(PresetError::NotPositive(name)) }
}

fn largest_tilt(tilt: f64) -> Result<f64, PresetError> {
    if tilt > 0.0 && tilt <= MOST_TILT_RAD { Ok(tilt) } else { Err(PresetError::Tilt) }
}

/// Returns a pose law whose gain suits an arm with this lag and delay.
fn pose(displacement: Option<Profile>, options: &PressOptions) -> Law {
    let to_rest = options.lag_s + f64::from(options.delay_periods) * options.period_s;
    Law::Pose {
        gain: PerAxis::All(if to_rest > 0.0 { POSE_GAIN.min(1.0 / (8.0 * to_rest)) } else { POSE_GAIN }),
        max_acceleration: None,
        braking: true,
        path: None,
        target_pose: TargetPose::Initial,
        target_displacement: displacement,
    }
}

/// Returns the task that holds what the others do not move, unless nothing is left.
fn hold(moved: &[Axis], frame: Frame, options: &PressOptions) -> Result<Option<ControllerTask>, PresetError> {
    let rest = || Axis::ALL.into_iter().filter(|axis| !moved.contains(axis)).collect();
    let axes: Vec<Axis> = options.hold.clone().unwrap_or_else(rest);
    for (k, axis) in axes.iter().enumerate() {
        if moved.contains(axis) {
            return Err(PresetError::Held(*axis));
        }
        if axes[..k].contains(axis) {
            return Err(PresetError::HeldTwice(*axis));
        }
    }
    Ok((!axes.is_empty()).then(|| task("hold", axes, frame, pose(None, options))))
}

fn task(name: &str, axes: Vec<Axis>, frame: Frame, law: Law) -> ControllerTask {
    ControllerTask {
        name: name.to_owned(),
        axes: Some(axes),
        frame,
        reference_point: None,
        link: None,
        relative_to: None,
        jacobian: None,
        law: Some(law),
        lower: None,
        upper: None,
        scale: false,
        streaming: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wipe_presses_moves_and_holds_the_rest() {
        let options = WipeOptions { stroke_m: -0.2, ..WipeOptions::default() };
        let tasks = wipe(Axis::Z, -15.0, Axis::Y, &options).unwrap();
        assert_eq!(tasks.iter().map(|task| task.name.as_str()).collect::<Vec<_>>(), ["push", "wipe", "hold"]);
        assert_eq!(tasks[2].axes, Some(vec![Axis::X, Axis::Rx, Axis::Ry, Axis::Rz]));
        let json = serde_json::to_value(&tasks[1]).unwrap();
        let way = &json["law"]["target_displacement"];
        assert_eq!((way["offset"].as_f64(), way["angular_frequency_rad_s"].as_f64()), (Some(-0.1), Some(0.5)));
    }

    #[test]
    fn a_wipe_begins_at_its_start_when_it_is_told() {
        let options = WipeOptions { start_time_s: 3.0, ..WipeOptions::default() };
        let json = serde_json::to_value(&wipe(Axis::Z, -15.0, Axis::X, &options).unwrap()[1]).unwrap();
        let number = |field: &str| json["law"]["target_displacement"][field].as_f64().unwrap();
        let phase = number("angular_frequency_rad_s") * 3.0 + number("phase_rad");
        assert!((number("offset") + number("amplitude") * phase.sin()).abs() < 1e-12, "{json}");
        let never = WipeOptions { start_time_s: f64::INFINITY, ..options };
        assert_eq!(wipe(Axis::Z, 5.0, Axis::X, &never), Err(PresetError::StartTime));
    }

    #[test]
    fn a_wipe_follows_a_surface_if_it_is_told_how_tilted_that_may_be() {
        let options = WipeOptions { max_tilt_rad: Some(0.6), ..WipeOptions::default() };
        let law = |options| serde_json::to_value(&wipe(Axis::Z, -15.0, Axis::X, options).unwrap()[0].law).unwrap();
        assert_eq!(law(&options)["surface"]["max_tilt_rad"], 0.6);
        assert!(law(&WipeOptions::default()).get("surface").is_none());
    }

    #[test]
    fn a_push_holds_what_it_is_told() {
        let options = PressOptions { hold: Some(vec![Axis::Y]), stiffest: Some(1e5), ..PressOptions::default() };
        assert_eq!(push(Axis::X, 5.0, &options).unwrap()[1].axes, Some(vec![Axis::Y]));
        let options = PressOptions { hold: Some(Vec::new()), ..options };
        assert_eq!(push(Axis::X, 5.0, &options).unwrap().len(), 1);
    }

    #[test]
    fn numbers_without_a_meaning_are_refused() {
        let options = PressOptions::default();
        for newtons in [0.0, f64::NAN, f64::INFINITY] {
            assert_eq!(push(Axis::X, newtons, &options), Err(PresetError::Force));
        }
        let slow = PressOptions { approach_speed: Some(0.0), ..options };
        assert_eq!(push(Axis::X, 5.0, &slow), Err(PresetError::NotPositive("the approach speed")));
        let wiping = WipeOptions::default();
        for along in [Axis::Z, Axis::Rx] {
            assert_eq!(wipe(Axis::Z, 5.0, along, &wiping), Err(PresetError::Along));
        }
        let still = WipeOptions { stroke_m: 0.0, ..wiping.clone() };
        assert_eq!(wipe(Axis::Z, 5.0, Axis::X, &still), Err(PresetError::Stroke));
        let upright = WipeOptions { max_tilt_rad: Some(0.0), ..wiping.clone() };
        let overhanging = WipeOptions { max_tilt_rad: Some(1.5), ..wiping.clone() };
        for tilted in [upright, overhanging] {
            assert_eq!(wipe(Axis::Z, 5.0, Axis::X, &tilted), Err(PresetError::Tilt));
        }
        let still = WipeOptions { speed: f64::NAN, ..wiping };
        assert_eq!(wipe(Axis::Z, 5.0, Axis::X, &still), Err(PresetError::NotPositive("the speed")));
    }
}
