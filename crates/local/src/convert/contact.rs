//! The law `contact`: its settings, its reports and its memory.

use revprio_api::wire::{self, PerAxis};
use revprio_core::controller::ControllerConfig;
use revprio_core::law::{
    ContactAxis, ContactLaw, ContactLawError, ContactPhase, ContactReport, ContactSettings, Following,
    StiffnessEstimate, SurfaceMotion, Swing, Unchanged,
};
use revprio_core::surface::{NormalEstimate, NormalReport, SurfaceSettings};
use revprio_robot::kinematics::{Axis, AxisSelection};

use super::checks::{Inside, Result, check, each};
use super::numbers::{check_remembered, number, remembered};
use super::profile::{PerRow, at_row};
use super::terms;
use crate::error::ApiError;

/// Reads the law for axes of the tool; `None`: it is another law. Pointers begin at the law.
pub fn contact_law(law: &wire::Law, axes: &AxisSelection) -> Result<Option<ContactLaw>> {
    let wire::Law::Contact { target_force, sensor_lag_s, surface, .. } = law else { return Ok(None) };
    let rows = PerRow { rows: axes.len() };
    let target = rows.profile(target_force).inside("/target_force")?;
    let is_angular = |axis: &Axis| matches!(axis, Axis::Rx | Axis::Ry | Axis::Rz);
    let mut settings: Vec<_> = axes.axes().iter().map(|axis| ContactSettings::of(is_angular(axis))).collect();
    for field in FIELDS {
        let Some(values) = field.values(law) else { continue };
        let numbers = rows.numbers(values, &format!("/{}", field.name))?;
        for (settings, value) in settings.iter_mut().zip(numbers) {
            (field.set)(settings, value);
        }
    }
    if let Some(lag) = sensor_lag_s {
        let lag = number(*lag, "/sensor_lag_s")?;
        for settings in &mut settings {
            settings.sensor_lag = lag;
        }
    }
    let contact = ContactLaw::new(target, settings);
    let contact = match surface {
        Some(surface) => {
            let given = surface.max_tilt_rad.map(|tilt| number(tilt, "/surface/max_tilt_rad")).transpose()?;
            let settings = given.map_or_else(SurfaceSettings::default, |max_tilt| SurfaceSettings { max_tilt });
            contact.and_then(|contact| contact.with_surface(settings))
        }
        None => contact,
    };
    contact.map(Some).map_err(|error| refused(&error, law))
}

/// A field of the law with one value per axis.
struct Field {
    name: &'static str,
    get: fn(&wire::Law) -> Option<&PerAxis<f64>>,
    set: fn(&mut ContactSettings, f64),
}

impl Field {
    fn values<'a>(&self, law: &'a wire::Law) -> Option<&'a PerAxis<f64>> {
        (self.get)(law)
    }
}

/// Names a field of the law once.
macro_rules! field {
    ($name:ident, $set:expr) => {
        Field {
            name: stringify!($name),
            get: |law| if let wire::Law::Contact { $name, .. } = law { $name.as_ref() } else { None },
            set: $set,
        }
    };
}

const FIELDS: [Field; 7] = [
    field!(approach_speed, |settings, value| settings.approach_speed = Some(value)),
    field!(stiffest, |settings, value| settings.stiffest = value),
    field!(noise, |settings, value| settings.noise = value),
    field!(bias, |settings, value| settings.bias = value),
    field!(max_force, |settings, value| settings.max_force = value),
    field!(retreat_speed, |settings, value| settings.retreat_speed = value),
    field!(max_acceleration, |settings, value| settings.max_acceleration = value),
];

fn refused(error: &ContactLawError, law: &wire::Law) -> ApiError {
    let pointer = match error {
        ContactLawError::Surface => "/surface".to_owned(),
        ContactLawError::Range { field: "max_tilt_rad", .. } => "/surface/max_tilt_rad".to_owned(),
        ContactLawError::Range { field, row, .. } => {
            let values = FIELDS.iter().find(|known| known.name == *field).and_then(|field| field.values(law));
            values.map_or(format!("/{field}"), |values| at_row(values, &format!("/{field}"), *row))
        }
        ContactLawError::NoDirection { .. } | ContactLawError::Size { .. } => "/target_force".to_owned(),
    };
    ApiError::invalid(pointer, error)
}

fn state(phase: ContactPhase) -> (wire::ContactState, Option<wire::ContactFault>) {
    match phase {
        ContactPhase::Approach => (wire::ContactState::Approach, None),
        ContactPhase::Contact => (wire::ContactState::Contact, None),
        ContactPhase::Loss => (wire::ContactState::Loss, None),
        ContactPhase::Fault(cause) => (wire::ContactState::Fault, Some(terms::fault_answer(cause))),
    }
}

/// Returns a report of an axis.
pub fn contact_answer(report: &ContactReport) -> wire::ContactReport {
    let (state, fault) = state(report.phase);
    wire::ContactReport {
        state,
        fault,
        event: report.is_new.then_some(state),
        force: report.force,
        target_force: report.target,
        stiffness_bound: report.stiffness_bound,
        stiffness: report.stiffness.map(|[stiffness, _]| stiffness),
        stiffness_uncertainty: report.stiffness.map(|[_, uncertainty]| uncertainty),
        predicted_force: report.predicted_force,
        surface_velocity: report.surface_velocity,
        energy_j: report.energy,
        approach_speed: report.approach_speed,
        unavoidable_peak: report.unavoidable_peak,
        surface: report.normal.as_ref().map(surface_answer),
    }
}

fn surface_answer(report: &NormalReport) -> wire::SurfaceReport {
    wire::SurfaceReport {
        normal: report.normal.into(),
        friction: report.friction,
        uncertainty_rad: report.deviation,
        is_limited: report.is_limited,
        max_speed: report.most_speed,
    }
}

/// Reads what the axes remember. The controller checks their number and their ranges.
pub fn contact_memory(contacts: &[wire::ContactMemory], config: &ControllerConfig) -> Result<Vec<ContactAxis>> {
    let rows = |task: &revprio_core::controller::TaskConfig| task.law.contact().map_or(0, ContactLaw::rows);
    let most = config.tasks.iter().map(rows).sum::<usize>();
    check(
        contacts.len() <= most,
        "/contacts",
        format_args!("give at most {most}, one per axis with the law `contact`"),
    )?;
    each("/contacts", contacts, |_, axis| axis_memory(axis))
}

fn axis_memory(axis: &wire::ContactMemory) -> Result<ContactAxis> {
    let [factor, amplitude, before] = axis.swing;
    let [unchanged, since, time] = axis.unchanged;
    check_remembered(&axis.swing, "/swing")?;
    check_remembered(&axis.unchanged, "/unchanged")?;
    Ok(ContactAxis {
        phase: phase(axis.state, axis.fault)?,
        position: remembered(axis.position, "/position")?,
        sensed_position: remembered(axis.sensed_position, "/sensed_position")?,
        force: remembered(axis.force, "/force")?,
        surface: remembered(axis.surface, "/surface")?,
        contact_time: remembered(axis.contact_time_s, "/contact_time_s")?,
        lack: remembered(axis.lack, "/lack")?,
        hold_time: remembered(axis.hold_time_s, "/hold_time_s")?,
        return_speed: remembered(axis.return_speed, "/return_speed")?,
        spent: remembered(axis.spent_j, "/spent_j")?,
        before_retreat: remembered(axis.before_retreat, "/before_retreat")?,
        force_before_retreat: remembered(axis.force_before_retreat, "/force_before_retreat")?,
        fault_position: remembered(axis.fault_position, "/fault_position")?,
        mean_target: remembered(axis.mean_target_force, "/mean_target_force")?,
        estimate: stiffness_memory((&axis.stiffness, &axis.means, &axis.sums), axis.followed.as_ref())?,
        motion: motion_memory(axis)?,
        following: following_memory(axis)?,
        swing: Swing { factor, amplitude, before, above: axis.is_above },
        unchanged: Unchanged {
            force: unchanged,
            position: since,
            time,
            change: remembered(axis.reading_change, "/reading_change")?,
            step: remembered(axis.reading_step, "/reading_step")?,
        },
        normal: axis.normal.as_ref().map_or(Ok(NormalEstimate::START), normal_memory)?,
    })
}

fn following_memory(axis: &wire::ContactMemory) -> Result<Following> {
    let Some(following) = axis.following else {
        return Ok(Following { position: axis.position, ..Following::default() });
    };
    check_remembered(&following, "/following")?;
    let [position, ahead, force, modelled, measured, time] = following;
    Ok(Following { position, ahead, force, velocities: [modelled, measured], time })
}

fn following_answer(following: &Following) -> [f64; 6] {
    let [modelled, measured] = following.velocities;
    [following.position, following.ahead, following.force, modelled, measured, following.time]
}

fn stiffness_memory(
    (stiffness, means, sums): (&[f64; 3], &[f64; 2], &[f64; 4]),
    followed: Option<&[f64; 8]>,
) -> Result<StiffnessEstimate> {
    let [position, force, velocity, rate, x, f, position_scatter, force_scatter] = *followed.unwrap_or(&[0.0; 8]);
    check_remembered(stiffness, "/stiffness")?;
    check_remembered(means, "/means")?;
    check_remembered(sums, "/sums")?;
    followed.map_or(Ok(()), |followed| check_remembered(followed, "/followed"))?;
    let ([upper, slope, uncertainty], [mean_position, mean_force]) = (*stiffness, *means);
    let [squared_position, product, squared_force, samples] = *sums;
    Ok(StiffnessEstimate {
        upper,
        slope,
        uncertainty,
        mean_position,
        mean_force,
        squared_position,
        product,
        squared_force,
        samples,
        followed: [position, force],
        rates: [velocity, rate],
        unforeseen: [x, f],
        scatter: [position_scatter, force_scatter],
    })
}

/// Returns what is followed of a held contact; `None` without one.
fn followed(estimate: &StiffnessEstimate) -> Option<[f64; 8]> {
    let ([position, force], [velocity, rate]) = (estimate.followed, estimate.rates);
    let ([x, f], [position_scatter, force_scatter]) = (estimate.unforeseen, estimate.scatter);
    (force != 0.0).then_some([position, force, velocity, rate, x, f, position_scatter, force_scatter])
}

fn motion_memory(axis: &wire::ContactMemory) -> Result<SurfaceMotion> {
    check_remembered(&axis.surface_motion, "/surface_motion")?;
    let [.., velocity] = axis.surface_motion;
    let Some(measured) = &axis.measured else { return Ok(SurfaceMotion::default()) };
    let wire::MeasuredContact { position, stiffness, means, sums, surface_motion, followed } = measured;
    let read = || {
        check_remembered(position, "/position")?;
        check_remembered(surface_motion, "/surface_motion")?;
        stiffness_memory((stiffness, means, sums), followed.as_ref())
    };
    let stiffness = read().map_err(|error| error.inside("/measured"))?;
    let ([tool, sensed, _], [short, long, lasts]) = (*position, *surface_motion);
    let motion = SurfaceMotion { tool: [tool, sensed], stiffness, velocity, ..SurfaceMotion::default() };
    // Without it, these numbers have another meaning: they are from an older memory.
    Ok(if followed.is_some() { SurfaceMotion { means: [long, short], lasts, ..motion } } else { motion })
}

fn motion_answer(motion: &SurfaceMotion) -> wire::MeasuredContact {
    let (stiffness, means, sums) = stiffness_answer(&motion.stiffness);
    let ([tool, sensed], [followed_position, _]) = (motion.tool, motion.stiffness.followed);
    wire::MeasuredContact {
        position: [tool, sensed, followed_position],
        stiffness,
        means,
        sums,
        surface_motion: [motion.means[1], motion.means[0], motion.lasts],
        followed: followed(&motion.stiffness),
    }
}

/// Returns the place of the surface as it is followed, the stiffness of that place, and the velocity of the surface.
fn surface_motion_answer(motion: &SurfaceMotion) -> [f64; 3] {
    let ([position, force], slope) = (motion.stiffness.followed, motion.stiffness.slope);
    let place = if slope > 0.0 { position - force / slope } else { 0.0 };
    [place, slope, motion.velocity]
}

fn stiffness_answer(estimate: &StiffnessEstimate) -> ([f64; 3], [f64; 2], [f64; 4]) {
    (
        [estimate.upper, estimate.slope, estimate.uncertainty],
        [estimate.mean_position, estimate.mean_force],
        [estimate.squared_position, estimate.product, estimate.squared_force, estimate.samples],
    )
}

fn normal_memory(memory: &wire::NormalMemory) -> Result<NormalEstimate> {
    let ([position, from], [force, from_force]) = (memory.position, memory.force);
    for (vector, pointer) in [
        (memory.normal, "/normal/normal"),
        (memory.mean, "/normal/mean"),
        (position, "/normal/position/0"),
        (from, "/normal/position/1"),
        (force, "/normal/force/0"),
        (from_force, "/normal/force/1"),
    ] {
        check_remembered(&vector, pointer)?;
    }
    let estimate = NormalEstimate {
        normal: memory.normal.into(),
        mean: memory.mean.into(),
        friction: remembered(memory.friction, "/normal/friction")?,
        variance: remembered(memory.variance, "/normal/variance")?,
        chords: remembered(memory.chords, "/normal/chords")?,
        is_sliding: memory.is_sliding,
        position: position.into(),
        force: force.into(),
        begin: [from.into(), from_force.into()],
    };
    let detail = "this is no estimate that an answer has given; send the memory of the last answer back unchanged";
    check(estimate.is_valid(), "/normal", format_args!("{detail}"))?;
    Ok(estimate)
}

fn normal_answer(estimate: &NormalEstimate) -> wire::NormalMemory {
    let [from, from_force] = estimate.begin;
    wire::NormalMemory {
        normal: estimate.normal.into(),
        mean: estimate.mean.into(),
        friction: estimate.friction,
        variance: estimate.variance,
        chords: estimate.chords,
        is_sliding: estimate.is_sliding,
        position: [estimate.position.into(), from.into()],
        force: [estimate.force.into(), from_force.into()],
    }
}

fn phase(state: wire::ContactState, fault: Option<wire::ContactFault>) -> Result<ContactPhase> {
    match (state, fault) {
        (wire::ContactState::Approach, None) => Ok(ContactPhase::Approach),
        (wire::ContactState::Contact, None) => Ok(ContactPhase::Contact),
        (wire::ContactState::Loss, None) => Ok(ContactPhase::Loss),
        (wire::ContactState::Fault, Some(cause)) => Ok(ContactPhase::Fault(terms::fault(cause))),
        _ => Err(ApiError::invalid("/fault", "give a fault in the state `fault`, and in no other")),
    }
}

/// Returns what the axes remember as a part of an answer.
pub fn contact_memory_answer(contacts: &[ContactAxis]) -> Vec<wire::ContactMemory> {
    contacts.iter().map(axis_answer).collect()
}

fn axis_answer(axis: &ContactAxis) -> wire::ContactMemory {
    let (state, fault) = state(axis.phase);
    let swing = &axis.swing;
    let (stiffness, means, sums) = stiffness_answer(&axis.estimate);
    wire::ContactMemory {
        state,
        fault,
        position: axis.position,
        sensed_position: axis.sensed_position,
        force: axis.force,
        surface: axis.surface,
        contact_time_s: axis.contact_time,
        lack: axis.lack,
        hold_time_s: axis.hold_time,
        return_speed: axis.return_speed,
        spent_j: axis.spent,
        before_retreat: axis.before_retreat,
        force_before_retreat: axis.force_before_retreat,
        fault_position: axis.fault_position,
        stiffness,
        means,
        sums,
        followed: followed(&axis.estimate),
        mean_target_force: axis.mean_target,
        surface_motion: surface_motion_answer(&axis.motion),
        measured: (axis.motion != SurfaceMotion::default()).then(|| motion_answer(&axis.motion)),
        following: Some(following_answer(&axis.following)),
        swing: [swing.factor, swing.amplitude, swing.before],
        is_above: swing.above,
        unchanged: [axis.unchanged.force, axis.unchanged.position, axis.unchanged.time],
        reading_change: axis.unchanged.change,
        reading_step: axis.unchanged.step,
        normal: (axis.normal != NormalEstimate::START).then(|| normal_answer(&axis.normal)),
    }
}
